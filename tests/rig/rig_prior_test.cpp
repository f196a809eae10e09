#include "core/rig/rig_prior.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/rig/residuals.h"
#include "core/rig/rig_axis.h"
#include "tests/rig/differences.h"

namespace rigcal {
namespace {

Rigid3d SomePose(double by) {
  return {ExpRotation({0.3 * by, -0.5, 0.2 * by}), {0.02, -0.03 * by, 0.6}};
}

/// Two cameras on an arm, everything but the skew known to some correlated uncertainty.
RigPrior ExamplePrior() {
  RigPrior prior;
  prior.cameras.resize(2);
  for (Camera& camera : prior.cameras) {
    camera.SetIntrinsics((IntrinsicVector() << 1520, 1510, 316, 243, 0, -0.11, 0.05, 2e-3, -1e-3, 0).finished());
  }
  prior.model = Arm(PositionerLoad::kCameras);
  prior.model.cam_from_mount = {SomePose(1), SomePose(-2)};
  prior.model.positioner.anchor_from_world = SomePose(0.5);
  const int size = RigCovariance::Size(2);
  Random random(3);
  Eigen::MatrixXd half = Eigen::MatrixXd::Zero(size, size);
  for (int row = 0; row < size; ++row) {
    if (row % kNumIntrinsics == kSkew && row < RigCovariance::MountRow(2, 0)) continue;
    for (int column = 0; column < size; ++column) half(row, column) = random.Normal();
  }
  prior.covariance.joint = half * half.transpose();
  return prior;
}

std::vector<std::vector<double>> BlocksOf(const RigPrior& prior) {
  std::vector<std::vector<double>> blocks;
  const auto add_pose = [&](const Rigid3d& pose) {
    const PoseBlock block = PoseBlockOf(pose);
    blocks.emplace_back(block.begin(), block.end());
  };
  for (const Camera& camera : prior.cameras) {
    const IntrinsicVector k = camera.Intrinsics();
    blocks.emplace_back(k.begin(), k.end());
  }
  for (const auto& mount : prior.model.cam_from_mount) add_pose(*mount);
  add_pose(prior.model.positioner.anchor_from_world);
  const auto axes = prior.model.positioner.axes_in_stage.reshaped();
  blocks.emplace_back(axes.begin(), axes.end());
  return blocks;
}

std::vector<double> Evaluated(const RigPriorResidual& residual, const std::vector<std::vector<double>>& blocks) {
  std::vector<const double*> pointers;
  for (const auto& block : blocks) pointers.push_back(block.data());
  std::vector<double> values(static_cast<std::size_t>(residual.num_residuals()));
  EXPECT_TRUE(residual.Evaluate(pointers.data(), values.data(), nullptr));
  return values;
}

TEST(RigPriorResidual, AgreesWithDifferencesFarFromTheMean) {
  const RigPrior prior = ExamplePrior();
  RigPrior at = prior;
  at.cameras[1].fx_px += 5;
  at.model.cam_from_mount[0] = Disturbed(SomePose(1), Eigen::Matrix<double, 6, 1>::Constant(0.2));
  at.model.positioner.anchor_from_world = Disturbed(SomePose(0.5), Eigen::Matrix<double, 6, 1>::Constant(-0.1));
  const PoseManifold pose;
  ExpectDifferencesAgree(RigPriorResidual(prior), {nullptr, nullptr, &pose, &pose, &pose, nullptr}, BlocksOf(at));
}

TEST(RigPriorResidual, IsTheDepartureInSigmas) {
  const RigPrior prior = ExamplePrior();
  const RigPriorResidual residual(prior);
  for (const double value : Evaluated(residual, BlocksOf(prior))) EXPECT_NEAR(value, 0, 1e-9);
  RigPrior at = prior;
  Eigen::Matrix<double, 6, 1> delta;
  delta << 0.1, -0.2, 0.05, 0.01, 0.02, -0.03;
  at.model.cam_from_mount[1] = Disturbed(SomePose(-2), delta);
  const std::vector<int> rows = prior.FreeRows();
  EXPECT_EQ(static_cast<int>(rows.size()), residual.num_residuals());
  EXPECT_EQ(residual.num_residuals(), RigCovariance::Size(2) - 2);
  Eigen::VectorXd departure = Eigen::VectorXd::Zero(prior.covariance.joint.rows());
  departure.segment<6>(RigCovariance::MountRow(2, 1)) = delta;
  EXPECT_LT((DepartureFrom(prior, at.cameras, at.model) - departure).norm(), 1e-12);
  const Eigen::MatrixXd covariance = prior.covariance.joint(rows, rows);
  const Eigen::VectorXd free = departure(rows);
  double chi_square = 0;
  for (const double value : Evaluated(residual, BlocksOf(at))) chi_square += value * value;
  EXPECT_NEAR(chi_square / free.dot(covariance.ldlt().solve(free)), 1, 1e-6);
}

TEST(LoosenMount, AddsAnIndependentErrorToOneMount) {
  RigPrior prior = ExamplePrior();
  const Eigen::MatrixXd before = prior.covariance.joint;
  LoosenMount(1, 0.1, 0.2, prior);
  const Eigen::MatrixXd added = prior.covariance.joint - before;
  const int row = RigCovariance::MountRow(2, 1);
  EXPECT_NEAR(added(row, row), 0.01, 1e-12);
  EXPECT_NEAR(added(row + 5, row + 5), 0.04, 1e-12);
  EXPECT_NEAR(added.cwiseAbs().sum(), 3 * (0.01 + 0.04), 1e-9);
}

TEST(LoosenLens, MovesTheFocalLengthsTogether) {
  RigPrior prior = ExamplePrior();
  const Eigen::MatrixXd before = prior.covariance.joint;
  LoosenLens(1, 0.01, 2, prior);
  const Eigen::MatrixXd added = prior.covariance.joint - before;
  const int row = RigCovariance::IntrinsicsRow(1);
  EXPECT_NEAR(added(row + kFx, row + kFx), 15.2 * 15.2, 1e-9);
  EXPECT_NEAR(added(row + kFx, row + kFy), 15.2 * 15.1, 1e-9);
  EXPECT_NEAR(added(row + kCy, row + kCy), 4, 1e-9);
  EXPECT_NEAR(added.cwiseAbs().sum(), std::pow(15.2 + 15.1, 2) + 8, 1e-6);
}

TEST(AxisOf, IsTheStagesZInTheFirstCameraThatHasAMount) {
  RigEstimate rig{.model = Turntable()};
  rig.model.cam_from_mount = {std::nullopt, SomePose(1)};
  const int row = RigCovariance::MountRow(2, 1);
  rig.covariance.joint = Eigen::MatrixXd::Zero(RigCovariance::Size(2), RigCovariance::Size(2));
  rig.covariance.joint.diagonal().segment<3>(row).setConstant(1e-8);
  const auto axis = AxisOf(rig);
  ASSERT_TRUE(axis);
  EXPECT_EQ(axis->camera, 1);
  EXPECT_LT((axis->direction_in_cam - SomePose(1).rotation * Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(axis->point_in_cam, SomePose(1).translation);
  EXPECT_NEAR(axis->direction_sigma_rad, 1e-4, 1e-9);
  rig.model = Gantry(1, PositionerLoad::kCameras);
  EXPECT_FALSE(AxisOf(rig));
}

}  // namespace
}  // namespace rigcal
