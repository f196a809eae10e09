#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// docs/formats.md says what each holds and where its pixel origin lies.
enum class ExportFormat { kMiddlebury, kColmap, kPmvs, kOpenCv };

/// "middlebury", "colmap", "pmvs", "opencv"; nothing for another name.
std::optional<ExportFormat> ExportFormatFromName(std::string_view name);

struct ExportOptions {
  ExportFormat format = ExportFormat::kMiddlebury;
  /// Write the cameras of the undistorted pictures (same K, no distortion) instead of those of the photographs.
  bool undistorted = false;
};

/// Writes a calibration for another program: a file `out` (middlebury, opencv) or files in the folder `out` (colmap,
/// pmvs). Returns sentences that the user should read. A camera that the format cannot hold is refused, never bent.
/// Errors: kUnsupported, kBadInput (a size that is needed is not known), kIo, kDiskFull.
Result<std::vector<std::string>> Export(const RigCalibration& calibration, const ExportOptions& options,
                                        const std::filesystem::path& out);

}  // namespace rigcal
