#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// Decodes a picture: 1 or 3 (BGR) channels of 8 or 16 bits, in the orientation of its pixels (EXIF is ignored). A file
/// that ends early is refused, also where the decoder would fill the rest with grey. `file` names it in messages.
/// Errors: kBadInput, kUnsupported (other depths).
Result<cv::Mat> DecodeImage(const std::string& bytes, const std::string& file);

/// Grey values in [0, 1].
cv::Mat1f GrayOf(const cv::Mat& image);

/// BGR, 8 bits, reduced by pyrDown to the level.
cv::Mat3b ColourOf(const cv::Mat& image, int level);

}  // namespace rigcal
