#pragma once

#include <map>
#include <string>

namespace rigcal {

/// The files of one exported calibration: path below the target folder and content. A format that is a single file
/// has one entry, whose name does not count.
using ExportedFiles = std::map<std::string, std::string>;

}  // namespace rigcal
