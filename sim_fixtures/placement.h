#pragma once

#include <span>

#include "core/scene/rig_calibration.h"
#include "sim_fixtures/studio.h"

namespace rigcal::sim {

/// The true cameras and where the table stood; see Studio.
struct Placement {
  RigCalibration truth;
  std::vector<Rigid3d> stage_from_world;
  std::vector<double> table_angle_rad;
  std::vector<int> stop;
  std::vector<double> commanded_rad;
  std::vector<StopError> stop_errors;
  std::vector<Rigid3d> cam_from_stage;
};

/// Puts cameras about an object so that it fills most of every picture. `surface_in_world`: points of the object.
Placement PlaceCameras(const StudioOptions& options, std::span<const Eigen::Vector3f> surface_in_world);

}  // namespace rigcal::sim
