#include "core/rig/poses_by_rig.h"

#include <vector>

#include "core/rig/rig_model_pose.h"

namespace rigcal {

Eigen::MatrixXd PosesByRig(const RigModel& model, std::span<const StopPosition> stops,
                           std::span<const StopError> stop_errors, std::span<const int> stop_of_view,
                           const RigCalibration& calibration) {
  const int n = calibration.NumCameras();
  const RigColumns columns{n, static_cast<int>(stops.size())};
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(CalibrationCovariance::PoseRow(n, calibration.NumViews()), columns.Count());
  for (int c = 0; c < n; ++c) {
    d.block<kNumIntrinsics, kNumIntrinsics>(CalibrationCovariance::IntrinsicsRow(c), RigCovariance::IntrinsicsRow(c))
        .setIdentity();
  }
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const int row = CalibrationCovariance::PoseRow(n, v), camera = calibration.views[v].camera;
    const int stop = stop_of_view[v];
    const RigPose pose =
        RigPoseAt(model.positioner, model.cam_from_mount[camera].value(), stops[stop], stop_errors[stop]);
    d.block<6, 6>(row, RigCovariance::MountRow(n, camera)) = pose.by_mount;
    d.block<6, 6>(row, RigCovariance::AnchorRow(n)) = pose.by_anchor;
    d.block<6, 9>(row, RigCovariance::AxesRow(n)) = pose.by_axes;
    d.block<6, kStopErrorSize>(row, columns.Stop(stop)) = pose.by_stop_error;
  }
  return d;
}

CalibrationCovariance CovarianceByRig(const RigEstimate& rig, std::span<const StopPosition> stops,
                                      std::span<const int> stop_of_view, const RigCalibration& calibration) {
  const std::vector<StopError> exact(stops.size(), StopError::Zero());
  const Eigen::MatrixXd by_rig = PosesByRig(rig.model, stops, exact, stop_of_view, calibration)
                                     .leftCols(RigCovariance::Size(calibration.NumCameras()));
  return {by_rig * rig.covariance.joint * by_rig.transpose()};
}

}  // namespace rigcal
