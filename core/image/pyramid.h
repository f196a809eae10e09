#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace rigcal {

/// levels[0] is the full-size image; levels[l] is cv::pyrDown of levels[l - 1], so that a point at x_0 lies at
/// x_l = x_0 / 2^l with pixel (0,0) the centre of the top-left pixel (DESIGN.md section 5; proved in tests/image).
using Pyramid = std::vector<cv::Mat1f>;

/// num_levels >= 1 counts the full-size image. The full-size image is shared, not copied.
Pyramid BuildPyramid(const cv::Mat1f& image, int num_levels);

}  // namespace rigcal
