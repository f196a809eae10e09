#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"

namespace rigcal {

/// Writes a whole file or leaves what was there: into a temporary file of the same folder, fsync, rename. Errors:
/// kDiskFull, kIo (the folder is missing or may not be written); the temporary file is removed.
Result<void> WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes);

/// Whether a file has the name that these functions give it until it is whole (".NAME.EXTENSION.XXXXXX"): a program
/// that was killed leaves such ones.
bool IsTemporaryName(std::string_view name);

/// Brings what was done in a folder (a new name, one that is gone) to the disk. 0 or errno.
int SyncFolder(const std::filesystem::path& folder);

/// The Error for a file or folder that could not be written: kDiskFull or kIo by `error` (errno).
tl::unexpected<Error> WriteFailure(const std::filesystem::path& path, int error);

/// Makes the folder, with its parents, unless it is there, and tries that a file can be written in it, so that a long
/// run does not fail at its end. Errors: kBadInput (the path is a file), kIo, kDiskFull.
Result<void> PrepareOutputFolder(const std::filesystem::path& folder);

}  // namespace rigcal
