#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/base/execution.h"

namespace rigcal {

/// Masks of an object on a dark cloth, from one threshold for all pictures of a camera (grey, [0, 1]): the foot of the
/// dark peak of their common histogram. Empty when the histogram has no dark peak that stands apart or when the
/// pictures' borders are not dark, or when stopped.
std::vector<cv::Mat1b> MasksOnDark(const std::vector<cv::Mat1f>& pictures, const Execution& execution);

}  // namespace rigcal
