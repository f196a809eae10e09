#include "core/rig/rig_residuals.h"

#include "core/rig/reprojection.h"

namespace rigcal {

RigPose RigView::PoseAt(double const* const* pose_blocks) const {
  Positioner at = positioner;
  at.anchor_from_world = PoseOf(pose_blocks[2]);
  at.axes_in_stage = Eigen::Map<const Eigen::Matrix3d>(pose_blocks[3]);
  return RigPoseAt(at, PoseOf(pose_blocks[0]), position, Eigen::Map<const StopError>(pose_blocks[1]));
}

void WriteRigPoseJacobians(const Eigen::Matrix<double, 2, 6>& by_pose, const RigPose& pose, double** jacobians) {
  const auto write_pose = [&](double* block, const Eigen::Matrix<double, 6, 6>& pose_by_block) {
    if (block == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor>> by_block(block);
    by_block.leftCols<6>().noalias() = by_pose * pose_by_block;
    by_block.col(6).setZero();
  };
  write_pose(jacobians[0], pose.by_mount);
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, kStopErrorSize, Eigen::RowMajor>>(jacobians[1]).noalias() =
        by_pose * pose.by_stop_error;
  }
  write_pose(jacobians[2], pose.by_anchor);
  if (jacobians[3] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, kAxesBlockSize, Eigen::RowMajor>>(jacobians[3]).noalias() =
        by_pose * pose.by_axes;
  }
}

bool RigFeatureResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  Camera camera;
  camera.SetIntrinsics(Eigen::Map<const IntrinsicVector>(parameters[0]));
  const RigPose pose = view_.PoseAt(parameters + 1);
  const Eigen::Map<const Eigen::Vector3d> x_in_world(parameters[1 + kRigPoseBlocks]);
  const std::optional<Reprojection> seen = Reproject(camera, pose.cam_from_world, x_in_world);
  if (!seen) return false;
  Eigen::Map<Eigen::Vector2d>(residuals).noalias() = whitening_ * (seen->x_px - x_px_);
  if (jacobians == nullptr) return true;
  if (jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, kNumIntrinsics, Eigen::RowMajor>>(jacobians[0]).noalias() =
        whitening_ * seen->by_intrinsics;
  }
  WriteRigPoseJacobians(whitening_ * seen->by_pose, pose, jacobians + 1);
  if (double* by_point = jacobians[1 + kRigPoseBlocks]; by_point != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(by_point).noalias() = whitening_ * seen->by_point;
  }
  return true;
}

}  // namespace rigcal
