#pragma once

#include <cmath>
#include <vector>

#include "tests/seed/synthetic_studio.h"

namespace rigcal::synthetic {

/// The 6 of Disturbed() that lead from one pose to another.
inline Eigen::Matrix<double, 6, 1> PoseDifference(const Rigid3d& to, const Rigid3d& from) {
  const Eigen::Quaterniond turn = to.rotation * from.rotation.conjugate();
  Eigen::Matrix<double, 6, 1> delta;
  delta.head<3>() = LogRotation(turn);
  delta.tail<3>() = to.translation - turn * from.translation;
  return delta;
}

/// (estimate - truth) / sigma, by kind of parameter.
struct Normalised {
  std::vector<double> intrinsics, poses, axis, stop_errors, board, hand_held;

  void Collect(const Studio& studio, const SeedResult& result) {
    const Eigen::VectorXd sigma = result.calibration.covariance->joint.diagonal().cwiseMax(0).cwiseSqrt();
    const int num_cameras = result.calibration.NumCameras();
    const auto push = [](std::vector<double>& list, double error, double one_sigma) {
      if (one_sigma > 0) list.push_back(error / one_sigma);
    };
    for (int c = 0; c < num_cameras; ++c) {
      const IntrinsicVector error = result.calibration.cameras[c].Intrinsics() - studio.truth.cameras[c].Intrinsics();
      for (int k = 0; k < kNumIntrinsics; ++k) {
        push(intrinsics, error[k], sigma[CalibrationCovariance::IntrinsicsRow(c) + k]);
      }
    }
    for (int i = 0; i < result.calibration.NumViews(); ++i) {
      const SeedView& view = studio.scene.views[result.view_of[i]];
      const StopMotion motion =
          MotionAt(studio.truth.rig.positioner, studio.scene.stops[*view.stop], studio.truth.stop_errors[*view.stop]);
      const auto error = PoseDifference(result.calibration.views[i].cam_from_world,
                                        CamFromWorld(*studio.truth.rig.cam_from_mount[view.camera], motion));
      for (int k = 0; k < 6; ++k) push(poses, error[k], sigma[CalibrationCovariance::PoseRow(num_cameras, i) + k]);
    }
    for (int c = 0; c < num_cameras; ++c) {
      const RigEstimate& rig = *result.calibration.rig;
      const auto error = PoseDifference(*rig.model.cam_from_mount[c], *studio.truth.rig.cam_from_mount[c]);
      const int row = RigCovariance::MountRow(num_cameras, c);
      for (int k = 0; k < 6; ++k) push(axis, error[k], std::sqrt(rig.covariance.joint(row + k, row + k)));
    }
    for (std::size_t s = 0; s < studio.truth.stop_errors.size(); ++s) {
      for (int k = 0; k < kStopErrorSize; ++k) {
        push(stop_errors, result.rig->stop_errors[s][k] - studio.truth.stop_errors[s][k],
             result.rig->stop_error_sigma[s][k]);
      }
    }
    push(board, result.board_shape.bow_x_m - studio.truth.shape.bow_x_m, result.board_shape_sigma.bow_x_m);
    push(board, result.board_shape.bow_y_m - studio.truth.shape.bow_y_m, result.board_shape_sigma.bow_y_m);
    push(board, result.board_shape.stretch - studio.truth.shape.stretch, result.board_shape_sigma.stretch);
    for (const HandHeldPose& held : result.hand_held) {
      const auto error = PoseDifference(held.cam_from_board, studio.cam_from_board[held.view]);
      for (int k = 0; k < 6; ++k) push(hand_held, error[k], std::sqrt(held.covariance(k, k)));
    }
  }
};

struct Moments {
  double mean = 0, deviation = 0;
};
inline Moments MomentsOf(const std::vector<double>& values) {
  double sum = 0, sum2 = 0;
  for (const double value : values) sum += value, sum2 += value * value;
  const double n = static_cast<double>(values.size());
  return {sum / n, std::sqrt(sum2 / n - sum / n * sum / n)};
}

/// How far the axis of the first camera is from the truth.
struct AxisError {
  double direction_rad = 0, point_m = 0;
};
inline AxisError AxisErrorOf(const Studio& studio, const SeedResult& result) {
  const AxisEstimate& axis = *result.rig->axis;
  const Rigid3d& truth = *studio.truth.rig.cam_from_mount[axis.camera];
  const Eigen::Vector3d direction = truth.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d off = axis.point_in_cam - truth.translation;
  return {std::acos(std::min(1.0, direction.dot(axis.direction_in_cam))),
          (off - off.dot(direction) * direction).norm()};
}

}  // namespace rigcal::synthetic
