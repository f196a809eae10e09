#pragma once

#include <map>
#include <string>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// Three cameras at a turntable, four stops, seen by readers of other formats: odd sizes, one upright, principal points
/// off the middle, fx != fy. The poses are those of the rig. Names of the images: left_0.png, ...
RigCalibration ExampleStudio();

/// By name, for the formats that cannot say all of it:
///   full     one camera with k1 k2 p1 p2 k3, one with k1 k2 p1 p2, one without distortion
///   no_k3    without k3
///   square   with k3, fx = fy
///   radial   fx = fy, principal point in the middle, k1 and k2 alone
///   skewed   no distortion, but skew
///   bent     distortion and skew
std::map<std::string, RigCalibration> ExportExamples();

}  // namespace rigcal
