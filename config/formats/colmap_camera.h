#pragma once

#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"

namespace rigcal {

/// A camera as COLMAP says it: the smallest of its models that holds all that the camera has.
struct ColmapCamera {
  const char* model = "";
  int model_id = 0;
  std::vector<double> parameters;
};

/// PINHOLE, OPENCV, or FULL_OPENCV when k3 is not 0.
ColmapCamera ColmapCameraOf(const Camera& camera);

/// qw qx qy qz tx ty tz.
std::vector<double> ColmapPose(const Rigid3d& b_from_a);

/// COLMAP counts from 1.
inline int ColmapId(int index) {
  return index + 1;
}

}  // namespace rigcal
