#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// What a physical camera did from one calibration to another, at the object: over all its views.
struct CameraMotion {
  std::string camera;  ///< physical_id
  int num_views = 0;
  double moved_px = 0;                                 ///< mean shift of the pictures of object points
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  ///< mean shift itself: shorter where views disagree on the way
  /// Its unit vector in the camera's picture (+x right, +y down); zero when nothing moved.
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();
  /// Root mean square of what both calibrations state for that shift, taken as independent: too large when one was the
  /// prior of the other. Nothing: one of them states no uncertainty.
  std::optional<double> sigma_px;

  [[nodiscard]] bool MovedMoreThanSigma() const { return sigma_px && moved_px > *sigma_px; }
};

struct CalibrationDifference {
  bool by_rig = false;  ///< both at the same exact stops, as their rigs place the cameras; else views of the same name
  int num_views = 0;
  double mean_px = 0;                                ///< of all views
  std::vector<CameraMotion> cameras;                 ///< in the order of `before`
  std::vector<std::string> only_before, only_after;  ///< cameras (physical_id) that the other does not have
};

/// Which camera moved, by how much, which way. Two calibrations with a rig of the same kind are compared at the stops
/// of `before`, so that the errors of single stops, different in each recording, do not count; others by the views that
/// both have. Points: SpreadPoints of `before`. With fewer than three cameras it cannot be told which one moved.
/// Errors: kBadInput: fewer than two views to compare, and those of SpreadPoints.
Result<CalibrationDifference> CompareCalibrations(const RigCalibration& before, const RigCalibration& after);

}  // namespace rigcal
