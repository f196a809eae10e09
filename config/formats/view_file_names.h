#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// For each view its image's name with another extension ("left/007.png" -> "left/007.xmp"). Errors: kUnsupported (two
/// images differ in their extension only).
Result<std::vector<std::string>> ViewFileNames(const RigCalibration& calibration, const std::string& extension);

}  // namespace rigcal
