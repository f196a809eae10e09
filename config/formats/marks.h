#pragma once

#include <string>
#include <string_view>

#include "config/formats/format_table.h"

namespace rigcal {

/// What an exported file begins with, where its format has room for a remark: by it the file is known again when it is
/// to be replaced. A file without it is somebody else's.
std::string ExportMark(std::string_view format_name);

/// Whether a single file is one of that format that an export wrote, so that another may take its place. Middlebury has
/// no room for a mark: there any whole file of that form counts.
bool IsExportOf(ExportFormat format, std::string_view text);

}  // namespace rigcal
