#include "core/rig/rig_prior.h"

#include "core/rig/camera_information.h"
#include "core/rig/residuals.h"
#include "core/rig/rig_model_pose.h"
#include "core/rig/rig_residuals.h"

namespace rigcal {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The 6 of Disturbed() that lead from `from` to `to`.
Vector6d Disturbance(const Rigid3d& to, const Rigid3d& from) {
  const PoseBlock y = PoseBlockOf(to), x = PoseBlockOf(from);
  Vector6d delta;
  PoseManifold().Minus(y.data(), x.data(), delta.data());
  return delta;
}

/// How Disturbance(to, from) changes when `to` is disturbed: turn' = Exp(dw) turn, and the shift t - turn t0 with it.
Eigen::Matrix<double, 6, 6> DisturbanceJacobian(const Vector6d& delta) {
  Eigen::Matrix<double, 6, 6> out = Eigen::Matrix<double, 6, 6>::Identity();
  out.topLeftCorner<3, 3>() = LeftJacobian(delta.head<3>()).inverse();
  out.bottomLeftCorner<3, 3>() = -Skew(delta.tail<3>());
  return out;
}

}  // namespace

std::vector<int> RigPrior::FreeRows() const {
  std::vector<int> rows;
  for (int row = 0; row < static_cast<int>(covariance.joint.rows()); ++row) {
    if (covariance.joint(row, row) > 0) rows.push_back(row);
  }
  return rows;
}

Eigen::VectorXd DepartureFrom(const RigPrior& prior, const std::vector<Camera>& cameras, const RigModel& model) {
  const int n = static_cast<int>(prior.cameras.size());
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(RigCovariance::Size(n));
  for (int c = 0; c < n; ++c) {
    delta.segment<kNumIntrinsics>(RigCovariance::IntrinsicsRow(c)) =
        cameras[c].Intrinsics() - prior.cameras[c].Intrinsics();
    if (!model.cam_from_mount[c] || !prior.model.cam_from_mount[c]) continue;
    delta.segment<6>(RigCovariance::MountRow(n, c)) =
        Disturbance(*model.cam_from_mount[c], *prior.model.cam_from_mount[c]);
  }
  delta.segment<6>(RigCovariance::AnchorRow(n)) =
      Disturbance(model.positioner.anchor_from_world, prior.model.positioner.anchor_from_world);
  delta.segment<kAxesBlockSize>(RigCovariance::AxesRow(n)) =
      (model.positioner.axes_in_stage - prior.model.positioner.axes_in_stage).reshaped();
  return delta;
}

void LoosenMount(int camera, double sigma_rad, double sigma_m, RigPrior& prior) {
  const int row = RigCovariance::MountRow(static_cast<int>(prior.cameras.size()), camera);
  auto diagonal = prior.covariance.joint.diagonal();
  diagonal.segment<3>(row).array() += sigma_rad * sigma_rad;
  diagonal.segment<3>(row + 3).array() += sigma_m * sigma_m;
}

void LoosenLens(int camera, double focal_share_sigma, double centre_sigma_px, RigPrior& prior) {
  const int row = RigCovariance::IntrinsicsRow(camera);
  const auto is_free = [&](int k) { return prior.covariance.joint(row + k, row + k) > 0; };
  const Eigen::Vector2d focal_px = focal_share_sigma * Eigen::Vector2d(is_free(kFx) ? prior.cameras[camera].fx_px : 0,
                                                                       is_free(kFy) ? prior.cameras[camera].fy_px : 0);
  static_assert(kFy == kFx + 1);
  prior.covariance.joint.block<2, 2>(row + kFx, row + kFx) += focal_px * focal_px.transpose();
  for (const int k : {kCx, kCy}) {
    if (is_free(k)) prior.covariance.joint(row + k, row + k) += centre_sigma_px * centre_sigma_px;
  }
}

RigPriorResidual::RigPriorResidual(const RigPrior& prior) : prior_(prior) {
  const std::vector<int> rows = prior.FreeRows();
  const auto num_free = static_cast<Eigen::Index>(rows.size());
  const Eigen::MatrixXd free = prior.covariance.joint(rows, rows);
  whitening_ = Eigen::MatrixXd::Zero(num_free, prior.covariance.joint.cols());
  whitening_(Eigen::all, rows) = CovarianceRoot(free).transpose();  // root * root^T is the inverse of `free`
  set_num_residuals(static_cast<int>(num_free));
  auto* sizes = mutable_parameter_block_sizes();
  sizes->insert(sizes->end(), prior.cameras.size(), kNumIntrinsics);
  sizes->insert(sizes->end(), prior.cameras.size(), kPoseBlockSize);
  sizes->insert(sizes->end(), {kPoseBlockSize, kAxesBlockSize});
}

bool RigPriorResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const int n = static_cast<int>(prior_.cameras.size());
  std::vector<Camera> cameras = prior_.cameras;
  RigModel model = prior_.model;
  for (int c = 0; c < n; ++c) {
    cameras[c].SetIntrinsics(IntrinsicVector::Map(parameters[c]));
    if (model.cam_from_mount[c]) model.cam_from_mount[c] = PoseOf(parameters[n + c]);
  }
  model.positioner.anchor_from_world = PoseOf(parameters[2 * n]);
  model.positioner.axes_in_stage = Eigen::Map<const Eigen::Matrix3d>(parameters[2 * n + 1]);
  const Eigen::VectorXd delta = DepartureFrom(prior_, cameras, model);
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()).noalias() = whitening_ * delta;
  if (jacobians == nullptr) return true;

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto write_plain = [&](double* block, int row, int size) {
    if (block != nullptr) Eigen::Map<RowMajor>(block, num_residuals(), size) = whitening_.middleCols(row, size);
  };
  const auto write_pose = [&](double* block, int row) {
    if (block == nullptr) return;
    Eigen::Map<RowMajor> by_pose(block, num_residuals(), kPoseBlockSize);
    by_pose.leftCols<6>().noalias() = whitening_.middleCols<6>(row) * DisturbanceJacobian(delta.segment<6>(row));
    by_pose.col(6).setZero();
  };
  for (int c = 0; c < n; ++c) {
    write_plain(jacobians[c], RigCovariance::IntrinsicsRow(c), kNumIntrinsics);
    write_pose(jacobians[n + c], RigCovariance::MountRow(n, c));
  }
  write_pose(jacobians[2 * n], RigCovariance::AnchorRow(n));
  write_plain(jacobians[2 * n + 1], RigCovariance::AxesRow(n), kAxesBlockSize);
  return true;
}

}  // namespace rigcal
