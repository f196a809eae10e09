#include "core/validate/camera_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/rig/rig_model_pose.h"
#include "core/validate/view_motion.h"
#include "tests/validate/cameras_for_test.h"

namespace rigcal {
namespace {

constexpr int kNumStops = 12;
constexpr double kFocalPx = 1000;

/// Four cameras about a turntable, 0.8 m away, as a run leaves them: views with the errors of their own stops, rig with
/// covariance. `night` turns the stops' errors about.
RigCalibration Studio(int night) {
  RigCalibration studio;
  studio.unit = LengthUnit::kMetre;
  RigEstimate rig{.model = Turntable(), .axes = {"table"}};
  std::vector<StopPosition> stops;
  std::vector<StopError> errors;
  for (int s = 0; s < kNumStops; ++s) {
    stops.push_back({fmt::format("{:02}", s), {2 * std::numbers::pi * s / kNumStops}, {}});
    StopError error = StopError::Zero();
    error[kStep] = 1e-3 * std::sin(3.0 * s + night), error[kWobbleX] = 3e-4 * std::cos(2.0 * s + night);
    errors.push_back(error);
  }
  std::vector<int> stop_of_view;
  for (int c = 0; c < 4; ++c) {
    const std::string id = fmt::format("cam{}", c);
    studio.cameras.push_back({.id = id, .physical_id = id, .width_px = 640, .height_px = 480});
    IntrinsicVector k = IntrinsicVector::Zero();
    k.head<4>() << kFocalPx, kFocalPx, 319.5, 239.5;
    studio.cameras.back().SetIntrinsics(k);
    const double at_rad = 0.7 * c;
    rig.model.cam_from_mount.push_back(
        test::LookingAt({0.8 * std::cos(at_rad), 0.8 * std::sin(at_rad), 0.2 + 0.1 * c}, {0, 0, 0.1}));
    for (int s = 0; s < kNumStops; ++s) {
      studio.views.push_back({fmt::format("{}/{:02}.png", id, s), c, {}});
      stop_of_view.push_back(s);
    }
  }
  PlaceViews(rig.model, stops, errors, stop_of_view, studio);
  constexpr double kMountSigmaRad = 2e-5;
  rig.covariance.joint = Eigen::MatrixXd::Zero(RigCovariance::Size(4), RigCovariance::Size(4));
  for (int c = 0; c < 4; ++c) {
    const int row = RigCovariance::MountRow(4, c);
    rig.covariance.joint.diagonal().segment<3>(row).setConstant(kMountSigmaRad * kMountSigmaRad);
  }
  studio.rig = std::move(rig);
  return studio;
}

void Turn(RigCalibration& studio, int camera, const Eigen::Vector3d& turn_rad) {
  Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
  delta.head<3>() = turn_rad;
  auto& mount = studio.rig->model.cam_from_mount[camera];
  mount = Disturbed(*mount, delta);
}

CalibrationDifference Compared(const RigCalibration& before, const RigCalibration& after) {
  const auto difference = CompareCalibrations(before, after);
  EXPECT_TRUE(difference) << (difference ? "" : difference.error().message);
  return difference.value_or(CalibrationDifference{});
}

TEST(CompareCalibrations, ErrorsOfSingleStopsAreNoMotionOfTheRig) {
  const auto difference = Compared(Studio(1), Studio(2));
  EXPECT_TRUE(difference.by_rig);
  ASSERT_EQ(difference.cameras.size(), 4U);
  // The stops differ by up to 2e-3 rad, 0.2 px at 0.1 m from the axis: by the views' names that would show.
  EXPECT_LT(difference.mean_px, 1e-6);
  for (const CameraMotion& motion : difference.cameras) EXPECT_FALSE(motion.MovedMoreThanSigma());
  RigCalibration one = Studio(1), other = Studio(2);
  one.rig.reset(), other.rig.reset();
  EXPECT_GT(Compared(one, other).mean_px, 0.05);
}

TEST(CompareCalibrations, TheCameraThatTurnedIsNamedWithItsWay) {
  RigCalibration after = Studio(2);
  constexpr double kTurnRad = 1e-3;  // about +y of the camera: what it sees moves to the right by f * turn
  Turn(after, 2, {0, kTurnRad, 0});
  const auto difference = Compared(Studio(1), after);
  ASSERT_EQ(difference.cameras.size(), 4U);
  const CameraMotion& turned = difference.cameras[2];
  EXPECT_EQ(turned.camera, "cam2");
  EXPECT_EQ(turned.num_views, kNumStops);
  // The best similarity takes its share: the others seem to have moved the other way a little.
  EXPECT_GT(turned.moved_px, 0.7 * kFocalPx * kTurnRad);
  EXPECT_LT(turned.moved_px, 1.1 * kFocalPx * kTurnRad);
  EXPECT_GT(turned.direction.x(), 0.95);
  EXPECT_NEAR(turned.shift_px.norm(), turned.moved_px, 0.1 * turned.moved_px);  // all its views agree
  EXPECT_LT((turned.shift_px.normalized() - turned.direction).norm(), 1e-12);
  EXPECT_TRUE(turned.MovedMoreThanSigma());
  for (const int other : {0, 1, 3}) EXPECT_LT(difference.cameras[other].moved_px, 0.5 * turned.moved_px) << other;
}

TEST(CompareCalibrations, SigmaIsThatOfBothTogether) {
  const auto difference = Compared(Studio(1), Studio(1));
  // 2e-5 rad about each of x, y, z, twice: f * 2e-5 * sqrt(2) for x and y together, sqrt(2) for two calibrations; less
  // what the best similarity takes.
  const double free_px = kFocalPx * 2e-5 * 2;
  for (const CameraMotion& motion : difference.cameras) {
    ASSERT_TRUE(motion.sigma_px);
    EXPECT_GT(*motion.sigma_px, 0.6 * free_px);
    EXPECT_LT(*motion.sigma_px, 1.1 * free_px);
  }
  RigCalibration small = Studio(1), moved = Studio(1);
  Turn(moved, 0, {0, 1e-5, 0});  // 0.01 px, a quarter of the sigma
  EXPECT_FALSE(Compared(small, moved).cameras[0].MovedMoreThanSigma());
  small.rig->covariance.joint *= 1e-4;  // so sure that it counts
  moved.rig->covariance.joint *= 1e-4;
  EXPECT_TRUE(Compared(small, moved).cameras[0].MovedMoreThanSigma());
}

TEST(CompareCalibrations, WithoutARigViewsOfTheSameNameCount) {
  const RigCalibration six = test::SixCameras();
  RigCalibration moved = test::InFrame(six, 3, ExpRotation({0.1, 0.2, 0.3}), {1, 2, 3});
  moved.views[4].cam_from_world.rotation = ExpRotation({0, 0, 0.02}) * moved.views[4].cam_from_world.rotation;
  const auto difference = Compared(six, moved);
  EXPECT_FALSE(difference.by_rig);
  EXPECT_EQ(difference.num_views, 6);
  ASSERT_EQ(difference.cameras.size(), 1U);
  EXPECT_FALSE(difference.cameras[0].sigma_px) << "neither states an uncertainty";
  EXPECT_FALSE(difference.cameras[0].MovedMoreThanSigma());
  EXPECT_GT(difference.mean_px, 0.3);
  for (View& view : moved.views) view.name += "_other";
  const auto refused = CompareCalibrations(six, moved);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, ::testing::HasSubstr("0 views to compare"));
}

TEST(CompareCalibrations, CamerasOfOneSideAreNamed) {
  RigCalibration after = Studio(1);
  after.cameras[3].id = after.cameras[3].physical_id = "new";
  const auto difference = Compared(Studio(1), after);
  EXPECT_THAT(difference.only_before, ::testing::ElementsAre("cam3"));
  EXPECT_THAT(difference.only_after, ::testing::ElementsAre("new"));
  EXPECT_EQ(difference.cameras.size(), 3U);
}

TEST(ViewMotions, NothingToAlignGivesNothing) {
  const RigCalibration six = test::SixCameras();
  EXPECT_TRUE(ViewMotions(six, six, {}).empty());
  RigCalibration one = six;
  one.views.resize(1);
  EXPECT_TRUE(ViewMotions(six, one, test::LatticePoints()).empty());
  EXPECT_EQ(ViewMotions(six, six, test::LatticePoints()).size(), 6U);
}

}  // namespace
}  // namespace rigcal
