#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/camera_records.h"

namespace rigcal {

/// The texts of a COLMAP model's cameras.txt and images.txt (points are ignored). Models with a pinhole and Brown
/// distortion are read; FULL_OPENCV only with k4 = k5 = k6 = 0. COLMAP puts the origin of pixels at the
/// corner of the top-left pixel. `folder` names the model in messages. Errors:
/// kBadInput, kUnsupported.
Result<std::vector<CameraRecord>> ParseColmapModel(std::string_view cameras_text, std::string_view images_text,
                                                   const std::string& folder);

}  // namespace rigcal
