#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/formats/format_table.h"
#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// The format that the name stands for ("colmap"); nothing for another name.
std::optional<ExportFormat> ExportFormatFromName(std::string_view name);

struct ExportOptions {
  ExportFormat format = ExportFormat::kMiddlebury;
  /// Write the cameras of undistorted pictures instead of those of the photographs: the same K without distortion; only
  /// where the format knows no other, with one focal length and a centred axis. Where K is another, a folder also gets
  /// undistort.yml, which says how to make such pictures.
  bool undistorted = false;
};

/// Writes a calibration for another program: a file or files in the folder `out`, whole or not at all. What stands at
/// `out` is replaced when it is an unchanged export in the same format (or an empty folder), and otherwise kept.
/// Returns sentences that the user should read. A camera that the format cannot hold is refused, never bent. Errors:
/// kUnsupported, kBadInput (a size that is needed is not known; something else stands at `out`), kIo, kDiskFull.
Result<std::vector<std::string>> Export(const RigCalibration& calibration, const ExportOptions& options,
                                        const std::filesystem::path& out);

}  // namespace rigcal
