#include "core/rig/residuals.h"

#include "core/rig/reprojection.h"

namespace rigcal {
namespace {

template <int kRows, int kCols>
using RowMajor = Eigen::Matrix<double, kRows, kCols, kCols == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

Camera CameraOf(const double* intrinsics_block) {
  Camera camera;
  camera.SetIntrinsics(Eigen::Map<const IntrinsicVector>(intrinsics_block));
  return camera;
}

/// Writes whitening * derivative into the blocks that Ceres asked for.
void WriteCameraJacobians(const Eigen::Matrix2d& whitening, const Reprojection& seen, double** jacobians) {
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor<2, kNumIntrinsics>>(jacobians[0]).noalias() = whitening * seen.by_intrinsics;
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<RowMajor<2, kPoseBlockSize>> by_pose(jacobians[1]);
    by_pose.leftCols<6>().noalias() = whitening * seen.by_pose;
    by_pose.col(6).setZero();
  }
}

}  // namespace

PoseBlock PoseBlockOf(const Rigid3d& cam_from_world) {
  const auto& q = cam_from_world.rotation;
  const auto& t = cam_from_world.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()};
}

Rigid3d PoseOf(const double* b) {
  return {Eigen::Quaterniond(b[3], b[0], b[1], b[2]), Eigen::Vector3d(b[4], b[5], b[6])};
}

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const PoseBlock moved = PoseBlockOf(Disturbed(PoseOf(x), Eigen::Map<const Eigen::Matrix<double, 6, 1>>(delta)));
  std::copy(moved.begin(), moved.end(), x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajor<kPoseBlockSize, 6>>(jacobian).setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Rigid3d to = PoseOf(y), from = PoseOf(x);
  const Eigen::Quaterniond turn = to.rotation * from.rotation.conjugate();
  Eigen::Map<Eigen::Matrix<double, 6, 1>> delta(y_minus_x);
  delta.head<3>() = LogRotation(turn);
  delta.tail<3>() = to.translation - turn * from.translation;
  return true;
}

bool PoseManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<RowMajor<6, kPoseBlockSize>>(jacobian).setIdentity();
  return true;
}

bool FeatureResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> x_in_world(parameters[2]);
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  const Camera camera = CameraOf(parameters[0]);
  const Rigid3d cam_from_world = PoseOf(parameters[1]);
  if (jacobians == nullptr) {
    const std::optional<Eigen::Vector2d> seen_px = Project(camera, cam_from_world * x_in_world);
    if (!seen_px) return false;
    residual.noalias() = whitening_ * (*seen_px - x_px_);
    return true;
  }
  const std::optional<Reprojection> seen = Reproject(camera, cam_from_world, x_in_world);
  if (!seen) return false;
  residual.noalias() = whitening_ * (seen->x_px - x_px_);
  WriteCameraJacobians(whitening_, *seen, jacobians);
  if (jacobians[2] != nullptr) Eigen::Map<RowMajor<2, 3>>(jacobians[2]).noalias() = whitening_ * seen->by_point;
  return true;
}

bool AnchorResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const std::optional<Reprojection> seen = Reproject(CameraOf(parameters[0]), PoseOf(parameters[1]), x_in_world_);
  if (!seen) return false;
  Eigen::Map<Eigen::Vector2d> residual(residuals);
  residual = (seen->x_px - seed_px_) / sigma_px_;
  if (jacobians != nullptr) WriteCameraJacobians(Eigen::Matrix2d::Identity() / sigma_px_, *seen, jacobians);
  return true;
}

bool IntrinsicsResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const double* k = parameters[0];
  residuals[0] = (k[kCx] - prior_.principal_point_px.x()) / prior_.principal_point_sigma_px;
  residuals[1] = (k[kCy] - prior_.principal_point_px.y()) / prior_.principal_point_sigma_px;
  residuals[2] = (k[kFx] / k[kFy] - prior_.aspect) / prior_.aspect_sigma;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<RowMajor<3, kNumIntrinsics>> j(jacobians[0]);
    j.setZero();
    j(0, kCx) = j(1, kCy) = 1 / prior_.principal_point_sigma_px;
    j(2, kFx) = 1 / (k[kFy] * prior_.aspect_sigma);
    j(2, kFy) = -k[kFx] / (k[kFy] * k[kFy] * prior_.aspect_sigma);
  }
  return true;
}

}  // namespace rigcal
