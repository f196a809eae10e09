#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// What a format cannot say, or needs to be told.
enum Gap : unsigned {
  kNoDistortion = 1U << 0,  ///< of any kind
  kNoTangential = 1U << 1,  ///< p1, p2
  kNoK3 = 1U << 2,
  kNoSkew = 1U << 3,
  kOneFocalLength = 1U << 4,  ///< fx = fy
  kCentred = 1U << 5,         ///< the principal point is the middle of the picture
  kNamesAreWords = 1U << 6,   ///< image names without blanks
  kNeedsSize = 1U << 7,
};
using Gaps = unsigned;  ///< of Gap, or-ed

/// "distortion, fx != fy": the gaps in words, for docs/formats.md.
std::string GapsText(Gaps gaps);

/// Whether a format with these gaps can hold the calibration. `title` names the format in messages. Errors:
/// kUnsupported, kBadInput (a size is not known).
Result<void> CheckFits(const RigCalibration& calibration, Gaps gaps, std::string_view title);

/// The cameras of undistorted pictures that a format with these gaps can hold: the same without distortion and, only
/// where the format knows no other, with one focal length (the geometric mean) or a centred axis, which needs the size.
/// Skew stays: cv::undistort, which such pictures are made with, cannot take it away.
RigCalibration UndistortedFor(const RigCalibration& calibration, Gaps gaps);

}  // namespace rigcal
