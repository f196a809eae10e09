#pragma once

#include <filesystem>
#include <string_view>

#include "config/formats/exported_files.h"
#include "core/base/result.h"

namespace rigcal {

/// Lists the files of an exported folder with their checksums, so that the next export knows what it may replace.
inline constexpr const char* kExportListFile = "rigcal_export.json";

/// Puts a folder with these files and their list at `out` in one step: it is written beside its place and takes it
/// whole. What stands there is replaced only when it is an empty folder, or when everything in it is an unchanged
/// export in the same format. Folders above `out` are made. Errors: kBadInput (something else stands there),
/// kUnsupported (a name leads out of the folder), kIo, kDiskFull.
Result<void> ReplaceExportFolder(std::string_view format_name, ExportedFiles files, const std::filesystem::path& out);

}  // namespace rigcal
