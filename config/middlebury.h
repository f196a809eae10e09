#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/camera_records.h"

namespace rigcal {

/// The text of a Middlebury *_par.txt: the number of images, then a line for each with its name and 21 numbers, K, R
/// and t row by row, P = K [R t]. Pixel (0,0) is read as the centre of the top-left pixel. Errors: kBadInput.
Result<std::vector<CameraRecord>> ParseMiddlebury(std::string_view text, const std::string& file);

/// The same text, with 17 significant digits. The cameras have no distortion (the caller has seen to it).
std::string MiddleburyText(const RigCalibration& calibration);

}  // namespace rigcal
