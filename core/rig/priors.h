#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// What is known of one camera's intrinsics before the run (DESIGN.md section 3, points 1 and 5).
struct CameraPrior {
  double aspect = 1.0;          ///< fx / fy
  double aspect_sigma = 0.005;  ///< a bare camera file: 0.5 %; a rig file: 0.1 %
  Eigen::Vector2d principal_point_px = Eigen::Vector2d::Zero();
  double principal_point_sigma_px = 3.0;
};

/// The seed is a measurement: its cameras, wrong by about expected_error_px in the picture (DESIGN.md section 3, point
/// 1).
struct SeedPrior {
  RigCalibration seed;
  double expected_error_px = 0;  ///< the run's initial Er
  int points_per_view = 12;
};

/// What is known of cameras and rig before a run: a normal density about cameras and model.
struct RigPrior {
  std::vector<Camera> cameras;
  RigModel model;
  RigCovariance covariance;

  /// Rows that are known to some uncertainty; the others are held.
  [[nodiscard]] std::vector<int> FreeRows() const;
};

}  // namespace rigcal
