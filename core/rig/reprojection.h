#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"

namespace rigcal {

/// Where a point of the world is seen, and the derivatives of that pixel.
struct Reprojection {
  Eigen::Vector2d x_px;
  Eigen::Matrix<double, 2, kNumIntrinsics> by_intrinsics;  ///< in the order of IntrinsicIndex
  Eigen::Matrix<double, 2, 6> by_pose;                     ///< by the delta of Disturbed(), at delta = 0
  Eigen::Matrix<double, 2, 3> by_point;                    ///< by x_in_world
};

/// Nothing when the point does not lie in front of the camera.
std::optional<Reprojection> Reproject(const Camera& camera, const Rigid3d& cam_from_world,
                                      const Eigen::Vector3d& x_in_world);

}  // namespace rigcal
