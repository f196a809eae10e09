#pragma once

#include <Eigen/Core>
#include <span>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// Columns of PosesByRig: those of RigCovariance, then kStopErrorSize for each stop.
struct RigColumns {
  int num_cameras = 0, num_stops = 0;
  [[nodiscard]] int Stop(int stop) const { return RigCovariance::Size(num_cameras) + kStopErrorSize * stop; }
  [[nodiscard]] int Count() const { return Stop(num_stops); }
};

/// How the intrinsics and poses of views that PlaceViews placed (rows as in CalibrationCovariance) follow from the rig
/// and the errors of its stops (RigColumns). All cameras with views have a mount.
Eigen::MatrixXd PosesByRig(const RigModel& model, std::span<const StopPosition> stops,
                           std::span<const StopError> stop_errors, std::span<const int> stop_of_view,
                           const RigCalibration& calibration);

/// Covariance of such views at stops without errors: what the rig's own covariance means for their pictures.
CalibrationCovariance CovarianceByRig(const RigEstimate& rig, std::span<const StopPosition> stops,
                                      std::span<const int> stop_of_view, const RigCalibration& calibration);

}  // namespace rigcal
