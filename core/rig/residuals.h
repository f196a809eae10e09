#pragma once

#include <ceres/manifold.h>
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"
#include "core/rig/priors.h"

namespace rigcal {

/// A pose as a block of Ceres parameters: quaternion x y z w, then the translation (cam_from_world).
inline constexpr int kPoseBlockSize = 7;
using PoseBlock = std::array<double, kPoseBlockSize>;
using IntrinsicsBlock = std::array<double, kNumIntrinsics>;
PoseBlock PoseBlockOf(const Rigid3d& cam_from_world);
Rigid3d PoseOf(const double* pose_block);

/// The 6 parameters of Disturbed() on a PoseBlock, so that steps and covariances mean the same. The residuals below
/// write their derivative by these 6 into the first 6 of the block's 7 columns, and PlusJacobian picks them; the
/// derivative by the quaternion itself is never formed.
class PoseManifold : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override { return kPoseBlockSize; }
  [[nodiscard]] int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// whitening * (projection - x_px): one feature. whitening^T whitening is the inverse of the feature's covariance.
/// Blocks: intrinsics, pose, point in the world. Fails (a step too far) where the point is not in front of the camera.
class FeatureResidual : public ceres::SizedCostFunction<2, kNumIntrinsics, kPoseBlockSize, 3> {
 public:
  FeatureResidual(const Eigen::Vector2d& x_px, const Eigen::Matrix2d& whitening) : x_px_(x_px), whitening_(whitening) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  Eigen::Vector2d x_px_;
  Eigen::Matrix2d whitening_;
};

/// (projection of a known point - seed_px) / sigma_px: the seed as a measurement (DESIGN.md section 3, point 1).
/// Blocks: intrinsics, pose.
class AnchorResidual : public ceres::SizedCostFunction<2, kNumIntrinsics, kPoseBlockSize> {
 public:
  AnchorResidual(const Eigen::Vector3d& x_in_world, const Eigen::Vector2d& seed_px, double sigma_px)
      : x_in_world_(x_in_world), seed_px_(seed_px), sigma_px_(sigma_px) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  Eigen::Vector3d x_in_world_;
  Eigen::Vector2d seed_px_;
  double sigma_px_;
};

/// Principal point and aspect ratio against a CameraPrior, each over its sigma (DESIGN.md section 3, points 1 and 5).
/// Residuals: cx, cy, fx / fy. Block: intrinsics.
class IntrinsicsResidual : public ceres::SizedCostFunction<3, kNumIntrinsics> {
 public:
  explicit IntrinsicsResidual(const CameraPrior& prior) : prior_(prior) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  CameraPrior prior_;
};

}  // namespace rigcal
