#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/base/execution.h"

namespace rigcal {

/// Masks of an object that turns in front of a fixed camera (pictures grey, [0, 1], all of one size): what differs from
/// the value that a pixel has in most pictures. Looked for at no more than kLongestSide_px, enlarged afterwards. Empty
/// for fewer than kFewestPictures, when the border of the pictures changes as well, or when stopped.
std::vector<cv::Mat1b> MasksOnStatic(const std::vector<cv::Mat1f>& pictures, const Execution& execution);
inline constexpr int kFewestPictures = 5;
inline constexpr int kLongestSide_px = 1300;

}  // namespace rigcal
