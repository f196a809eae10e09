#include <gtest/gtest.h>

#include <numbers>

#include "core/rig/rig_model_pose.h"
#include "core/rig/rig_residuals.h"

namespace rigcal {
namespace {

constexpr double kRightAngle = std::numbers::pi / 2;

StopPosition AtAngle(double angle_rad) {
  return {"", {angle_rad}, std::nullopt};
}

TEST(RigModel, TurntableTurnsTheObjectCounterClockwiseSeenFromAbove) {
  const StopMotion motion = MotionAt(Turntable().positioner, AtAngle(kRightAngle), StopError::Zero());
  EXPECT_LT((motion.stage_from_world * Eigen::Vector3d(1, 0, 0.5) - Eigen::Vector3d(0, 1, 0.5)).norm(), 1e-12);
  EXPECT_LT((motion.mount_from_stage * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  // A camera on +x looking at the axis sees the point that turned from +x to +y move to its right.
  const Rigid3d cam_from_stage{Eigen::Quaterniond((Eigen::Matrix3d() << 0, 1, 0, 0, 0, -1, -1, 0, 0).finished()),
                               {0, 0, 2}};
  EXPECT_NEAR((CamFromWorld(cam_from_stage, motion) * Eigen::Vector3d(0.1, 0, 0)).x(), 0.1, 1e-12);
}

TEST(RigModel, TurntableErrorsAreInTheStage) {
  StopError error = StopError::Zero();
  error[kStep] = 0.01, error[kRunOutX] = 1e-3;
  const StopMotion motion = MotionAt(Turntable().positioner, AtAngle(kRightAngle), error);
  const Eigen::Vector3d expected(-std::sin(0.01) + 1e-3, std::cos(0.01), 0);
  EXPECT_LT((motion.stage_from_world * Eigen::Vector3d::UnitX() - expected).norm(), 1e-12);
}

TEST(RigModel, GantryCarriesTheCamerasOrTheObject) {
  const StopPosition position{"", {0.2, 0.3}, std::nullopt};
  StopError error = StopError::Zero();
  error[4] = 0.01;
  const StopMotion cameras = MotionAt(Gantry(2, PositionerLoad::kCameras).positioner, position, error);
  EXPECT_LT((CamFromWorld({}, cameras) * Eigen::Vector3d(0.2, 0.31, 1) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  const StopMotion object = MotionAt(Gantry(2, PositionerLoad::kObject).positioner, position, error);
  EXPECT_LT((object.stage_from_world * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0.2, 0.31, 1)).norm(), 1e-12);
}

TEST(RigModel, ArmCarriesTheCamerasOrTheObject) {
  const Rigid3d base_from_flange{ExpRotation({0, 0, kRightAngle}), {0.5, 0, 0}};
  const StopPosition position{"", {}, base_from_flange};
  RigModel rig = Arm(PositionerLoad::kCameras);
  rig.positioner.anchor_from_world.translation = {0, 0, -1};
  const StopMotion cameras = MotionAt(rig.positioner, position, StopError::Zero());
  // 1 m above the flange's place in the base is 1 m along the world's z: the flange's origin.
  EXPECT_LT((CamFromWorld({}, cameras) * Eigen::Vector3d(0.5, 0, 1)).norm(), 1e-12);
  rig.positioner.load = PositionerLoad::kObject;
  const StopMotion object = MotionAt(rig.positioner, position, StopError::Zero());
  EXPECT_LT((object.stage_from_world * Eigen::Vector3d(1, 0, 1) - Eigen::Vector3d(0.5, 1, 0)).norm(), 1e-12);
}

Rigid3d Mount() {
  return {ExpRotation({1.9, -0.3, 0.2}), {0.05, -0.02, 0.6}};
}

/// A rig of each kind, with a stop and errors well away from zero.
struct RigCase {
  RigModel rig;
  StopPosition position;
};
std::vector<RigCase> RigCases() {
  std::vector<RigCase> cases = {{Turntable(), AtAngle(0.7)}};
  for (const PositionerLoad load : {PositionerLoad::kObject, PositionerLoad::kCameras}) {
    cases.push_back({Gantry(3, load), {"", {0.02, -0.03, 0.01}, std::nullopt}});
    cases.back().rig.positioner.axes_in_stage = ExpRotation({0.1, 0.3, -0.2}).toRotationMatrix();
    cases.push_back({Arm(load), {"", {}, Rigid3d{ExpRotation({0.1, 0.02, -0.1}), {0.03, -0.01, 0.02}}}});
    cases.back().rig.positioner.anchor_from_world = {ExpRotation({-0.03, 0.1, 0.05}), {0.01, 0.02, -0.03}};
  }
  return cases;
}

TEST(RigModel, StopAtGivesTheStopBack) {
  for (const RigCase& test : RigCases()) {
    const Positioner& positioner = test.rig.positioner;
    const auto placed = [&](const StopPosition& position) {
      return CamFromWorld(Mount(), MotionAt(positioner, position, StopError::Zero()));
    };
    const Rigid3d pose = placed(test.position);
    const StopPosition stop = StopAt(positioner, Mount(), pose);
    ASSERT_EQ(stop.axes.size(), test.position.axes.size());
    for (std::size_t k = 0; k < stop.axes.size(); ++k) EXPECT_NEAR(stop.axes[k], test.position.axes[k], 1e-12);
    const Rigid3d again = placed(stop);
    EXPECT_LT((again.translation - pose.translation).norm(), 1e-12);
    EXPECT_LT(again.rotation.angularDistance(pose.rotation), 1e-7);  // arc cosine near 1
  }
}

TEST(RigFeatureResidual, AgreesWithDifferences) {
  for (const RigCase& test : RigCases()) {
    const RigView view{test.rig.positioner, test.position};
    const RigFeatureResidual residual(view, {400, 200}, (Eigen::Matrix2d() << 3, 0.4, -0.2, 2).finished());
    IntrinsicVector k;
    k << 1520, 1510, 316, 243, 0, -0.11, 0.05, 0.002, -0.0015, 0.01;
    PoseBlock mount = PoseBlockOf(Mount()), anchor = PoseBlockOf(test.rig.positioner.anchor_from_world);
    StopErrorBlock error = {0.02, -0.01, 0.03, 0.004, -0.003, 0.002};
    AxesBlock axes;
    Eigen::Matrix3d::Map(axes.data()) = test.rig.positioner.axes_in_stage;
    std::array<double, 3> point = {0.05, -0.04, 0.06};
    const std::array<double*, 6> blocks = {k.data(),      mount.data(), error.data(),
                                           anchor.data(), axes.data(),  point.data()};
    const std::array<int, 6> sizes = {kNumIntrinsics, kPoseBlockSize, kStopErrorSize,
                                      kPoseBlockSize, kAxesBlockSize, 3};
    std::array<std::vector<double>, 6> jacobian_values;
    std::array<double*, 6> jacobians;
    for (int b = 0; b < 6; ++b) {
      jacobian_values[b].resize(2 * sizes[b]);
      jacobians[b] = jacobian_values[b].data();
    }
    const auto evaluate = [&] {
      Eigen::Vector2d value;
      EXPECT_TRUE(residual.Evaluate(blocks.data(), value.data(), nullptr));
      return value;
    };
    Eigen::Vector2d value;
    ASSERT_TRUE(residual.Evaluate(blocks.data(), value.data(), jacobians.data()));
    EXPECT_LT((value - evaluate()).norm(), 1e-12);
    for (int b = 0; b < 6; ++b) {
      const bool pose = b == 1 || b == 3;
      const Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> analytic(jacobians[b], 2, sizes[b]);
      const std::vector<double> kept(blocks[b], blocks[b] + sizes[b]);
      for (int i = 0; i < (pose ? 6 : sizes[b]); ++i) {
        const double step = 1e-6 * std::max(1.0, pose ? 1.0 : std::abs(kept[i]));
        const auto at = [&](double sign) {
          if (pose) {
            Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
            delta[i] = sign * step;
            PoseManifold().Plus(kept.data(), delta.data(), blocks[b]);
          } else {
            blocks[b][i] = kept[i] + sign * step;
          }
          const Eigen::Vector2d moved = evaluate();
          std::copy(kept.begin(), kept.end(), blocks[b]);
          return moved;
        };
        const Eigen::Vector2d difference = (at(1) - at(-1)) / (2 * step);
        EXPECT_LT((analytic.col(i) - difference).norm(), 1e-5 * (1 + difference.norm()))
            << "kind " << static_cast<int>(test.rig.positioner.kind) << " load "
            << static_cast<int>(test.rig.positioner.load) << " block " << b << " component " << i;
      }
    }
  }
}

}  // namespace
}  // namespace rigcal
