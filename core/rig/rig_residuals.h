#pragma once

#include <ceres/sized_cost_function.h>

#include <optional>

#include "core/rig/residuals.h"
#include "core/rig/rig_model_pose.h"

namespace rigcal {

using StopErrorBlock = std::array<double, kStopErrorSize>;
inline constexpr int kAxesBlockSize = 9;  ///< Positioner::axes_in_stage, column by column
using AxesBlock = std::array<double, kAxesBlockSize>;

/// A view whose pose is that of the rig model: which stop it was taken at. Its pose depends on four blocks:
/// cam_from_mount (PoseBlock), the stop's error, anchor_from_world (PoseBlock), the gantry's axes. Blocks that the kind
/// of positioner does not have are to be held constant.
inline constexpr int kRigPoseBlocks = 4;
struct RigView {
  Positioner positioner;  ///< kind, load and number of axes; geometry is in the blocks
  StopPosition position;

  /// Pose and derivatives at the values of the four blocks.
  [[nodiscard]] RigPose PoseAt(double const* const* pose_blocks) const;
};

/// d pixel / d pose (2x6, by Disturbed()) carried on into the four blocks' Jacobians, as FeatureResidual writes its
/// own; null blocks are left out.
void WriteRigPoseJacobians(const Eigen::Matrix<double, 2, 6>& by_pose, const RigPose& pose, double** jacobians);

/// FeatureResidual with the rig model's pose in the place of a free one. Blocks: intrinsics, the four of RigView, point
/// in the world.
class RigFeatureResidual : public ceres::SizedCostFunction<2, kNumIntrinsics, kPoseBlockSize, kStopErrorSize,
                                                           kPoseBlockSize, kAxesBlockSize, 3> {
 public:
  /// `view` must outlive the residual.
  RigFeatureResidual(const RigView& view, const Eigen::Vector2d& x_px, const Eigen::Matrix2d& whitening)
      : view_(view), x_px_(x_px), whitening_(whitening) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const RigView& view_;
  Eigen::Vector2d x_px_;
  Eigen::Matrix2d whitening_;
};

}  // namespace rigcal
