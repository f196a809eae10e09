#pragma once

#include <cmath>
#include <vector>

#include "core/seed/axis_on_board.h"
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

/// How far the axis is from the truth: in the first camera, where it shares the errors of that camera's lens, and on
/// the board, where it goes through the plane of the print. The wobble of the stops does not average to zero, and
/// nothing tells its mean from the axis: `turned` is against the axis about which the table really turned at these
/// stops.
struct AxisError {
  double direction_rad = 0, point_m = 0;
  double direction_on_board_rad = 0, turned_on_board_rad = 0, point_on_board_m = 0;
};
inline double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}
/// The stage's vertical as the table has it, mean over the stops.
inline Eigen::Vector3d TurnedAxisInWorld(const Studio& studio) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t s = 0; s < studio.truth.stop_errors.size(); ++s) {
    const StopMotion motion = MotionAt(studio.truth.rig.positioner, studio.scene.stops[s], studio.truth.stop_errors[s]);
    sum += motion.stage_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  }
  return sum.normalized();
}
inline AxisError AxisErrorOf(const Studio& studio, const SeedResult& result) {
  const AxisEstimate& axis = *result.rig->axis;
  const Rigid3d& truth = *studio.truth.rig.cam_from_mount[axis.camera];
  const Eigen::Vector3d direction = truth.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d off = axis.point_in_cam - truth.translation;
  const AxisOnBoard on_board =
      AxisOnBoardOf(studio.truth.place, studio.scene.board.thickness_m, Eigen::Matrix4d::Zero());
  const Rigid3d world_from_board = WorldFromBoard(studio.truth.place, studio.scene.board.thickness_m);
  const Eigen::Vector3d& found_on_board = result.axis_on_board->direction_in_board;
  return {AngleBetween(direction, axis.direction_in_cam), (off - off.dot(direction) * direction).norm(),
          AngleBetween(on_board.direction_in_board, found_on_board),
          AngleBetween(world_from_board.rotation.conjugate() * TurnedAxisInWorld(studio), found_on_board),
          (on_board.point_in_board - result.axis_on_board->point_in_board).norm()};
}

}  // namespace rigcal::synthetic
