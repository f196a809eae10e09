#pragma once

#include <cmath>
#include <numbers>
#include <string>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// Views on a circle of 0.5 m about the origin that look at it, +z of the world up; names ring_00.png, ring_01.png, ...
/// One camera of 64 x 48 pixels without distortion; the numbers have no short decimal form.
inline RigCalibration ExampleRing(int num_views) {
  RigCalibration ring;
  ring.unit = LengthUnit::kMetre;
  Camera camera;
  camera.id = camera.physical_id = "camera";
  camera.width_px = 64, camera.height_px = 48;
  camera.fx_px = 100.0 / 3, camera.fy_px = 100.0 / 3 + 1.0 / 7;
  camera.cx_px = 31.5 + 1.0 / 3, camera.cy_px = 23.5 - 1.0 / 7;
  ring.cameras.push_back(camera);
  constexpr double kRadius = 0.5;
  for (int v = 0; v < num_views; ++v) {
    const double angle_rad = 2 * std::numbers::pi * v / num_views;
    const Eigen::Vector3d outwards(std::cos(angle_rad), std::sin(angle_rad), 0);
    Eigen::Matrix3d world_from_cam;  // columns: the camera's right, down and forward in the world
    world_from_cam.col(2) = -outwards;
    world_from_cam.col(1) = -Eigen::Vector3d::UnitZ();
    world_from_cam.col(0) = world_from_cam.col(1).cross(world_from_cam.col(2));
    const Rigid3d pose{Eigen::Quaterniond(world_from_cam), kRadius * outwards};
    ring.views.push_back({fmt::format("ring_{:02}.png", v), 0, pose.Inverse()});
  }
  return ring;
}

}  // namespace rigcal
