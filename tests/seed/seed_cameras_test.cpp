#include "core/seed/seed_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/seed/seed_honesty.h"

namespace rigcal {
namespace {

using namespace synthetic;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(SeedCameras, RecoversTheTurntableStudio) {
  const Studio studio = TurntableStudio(1, {.large_board = true});
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_LT(result->report.rms_px, 0.15);
  EXPECT_THAT(result->report.contradictions, IsEmpty());
  for (int c = 0; c < 3; ++c) {
    const Camera& truth = studio.truth.cameras[c];
    EXPECT_NEAR(result->calibration.cameras[c].fx_px / truth.fx_px, 1, 5e-4);
    EXPECT_NEAR(result->calibration.cameras[c].fy_px / truth.fy_px, 1, 5e-4);
    EXPECT_NEAR(result->report.cameras[c].noise_scale, 0.5, 0.02);  // 0.05 px of noise, 0.1 px stated
    EXPECT_FALSE(result->report.cameras[c].uses_k3);
  }
  const AxisError axis = AxisErrorOf(studio, *result);
  // In the camera's frame the axis is as uncertain as principal point and focal length make it.
  EXPECT_LT(axis.direction_rad, 4 * result->rig->axis->direction_sigma_rad);
  EXPECT_LT(axis.point_m, 4 * result->rig->axis->point_sigma_m);
  EXPECT_LT(axis.turned_on_board_rad, 0.01 * kDegree);  // issue 3
  EXPECT_LT(axis.point_on_board_m, 2e-5);               // issue 3
  EXPECT_LT(axis.point_on_board_m, 4 * result->axis_on_board->point_sigma_m);
  EXPECT_LT(axis.direction_on_board_rad, 4 * result->axis_on_board->direction_sigma_rad);
  EXPECT_LT(result->rig->axis->direction_sigma_rad, 0.02 * kDegree);
  EXPECT_LT(result->rig->axis->point_sigma_m, 2e-4);
  EXPECT_NEAR(result->board_shape.bow_x_m, 2e-4, 2e-5);
  EXPECT_NEAR(result->board_shape.bow_y_m, -1e-4, 2e-5);
  EXPECT_NEAR(result->board_shape.stretch, 5e-4, 2e-5);
  EXPECT_EQ(result->calibration.NumViews(), 36);
  EXPECT_EQ(result->hand_held.size(), 45U);
}

TEST(SeedCameras, StatesItsUncertaintyHonestly) {
  StudioOptions options;
  options.draw_shape = true;
  options.num_stops = 8;
  options.hand_held_per_camera = 8;
  Normalised normalised;
  for (std::uint64_t run = 0; run < 10; ++run) {
    const Studio studio = TurntableStudio(DeriveSeed(2, run), options);
    const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
    ASSERT_TRUE(result) << result.error().message;
    normalised.Collect(studio, *result);
  }
  for (const auto* list :
       {&normalised.intrinsics, &normalised.poses, &normalised.axis, &normalised.stop_errors, &normalised.hand_held}) {
    const Moments moments = MomentsOf(*list);
    EXPECT_LT(std::abs(moments.mean), 0.3);
    EXPECT_GT(moments.deviation, 0.8);
    EXPECT_LT(moments.deviation, 1.25);
  }
}

TEST(SeedCameras, SecondRunIsByteIdentical) {
  const Studio studio = TurntableStudio(3, {.num_stops = 6, .hand_held_per_camera = 5});
  const Result<SeedResult> a = SeedCameras(studio.scene, {}, {}), b = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->calibration.covariance->joint, b->calibration.covariance->joint);
  EXPECT_EQ(a->calibration.cameras[2].fx_px, b->calibration.cameras[2].fx_px);
}

TEST(SeedCameras, WrongCornersAreLeftOut) {
  const Studio studio = TurntableStudio(4, {.outlier_share = 0.03});
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_NEAR(result->calibration.cameras[0].fx_px / studio.truth.cameras[0].fx_px, 1, 1e-3);
  EXPECT_GT(result->report.cameras[0].num_outliers, 15);
  EXPECT_THAT(result->report.contradictions, IsEmpty());
}

TEST(SeedCameras, NamesTheStopThatSlipped) {
  const Studio studio = TurntableStudio(5, {.slip_rad = 1 * kDegree});
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.contradictions, ElementsAre(HasSubstr("stop 4: step error of")));
  EXPECT_NEAR(result->rig->stop_errors[4][kStep], studio.truth.stop_errors[4][kStep] + 1 * kDegree, 0.03 * kDegree);
  EXPECT_LT(AxisErrorOf(studio, *result).direction_rad, 0.06 * kDegree);
}

TEST(SeedCameras, ANoisyPictureDoesNotContradictTheRig) {
  Studio studio = TurntableStudio(8, {});
  Random random(2);
  studio.scene.sightings[7] = See(studio, 7, {.noise_px = 0.2}, random);  // the others: 0.05 px
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.contradictions, IsEmpty());
  EXPECT_EQ(result->calibration.NumViews(), 36);
}

TEST(SeedCameras, NamesTheCameraThatMoved) {
  const Studio studio = TurntableStudio(6, {.bump_rad = 0.5 * kDegree});
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.contradictions,
              ElementsAre(testing::AllOf(HasSubstr("camera cam1 moved"), HasSubstr("stops 7, 8, 9, 10, 11"))));
  EXPECT_LT(AxisErrorOf(studio, *result).direction_rad, 0.06 * kDegree);
  EXPECT_EQ(result->calibration.NumViews(), 31);
}

TEST(SeedCameras, OfASingleCameraThatMovedItSaysThatItCannotBeDecided) {
  Studio studio = TurntableStudio(7, {.num_cameras = 1});
  Random random(1);
  for (int v = 8; v < 12; ++v) {
    studio.cam_from_board[v].rotation = ExpRotation({0.02, 0.03, 0.01}) * studio.cam_from_board[v].rotation;
    studio.scene.sightings[v] = See(studio, v, {}, random);
  }
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.contradictions,
              Contains(testing::AllOf(HasSubstr("camera cam0"), HasSubstr("cannot be decided"))));
  EXPECT_THAT(result->report.contradictions, testing::Each(HasSubstr("camera cam0")));
}

TEST(SeedCameras, TurningTheOtherWayContradicts) {
  Studio studio = TurntableStudio(8);
  for (StopPosition& stop : studio.scene.stops) stop.axes[0] = -stop.axes[0];
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.contradictions, Contains(HasSubstr("turns against its stated angles")));
}

TEST(SeedCameras, ViewsAndStopsWithoutChartAreNormal) {
  Studio studio = TurntableStudio(9);
  for (ChartSighting& sighting : studio.scene.sightings) {
    const SeedView& view = studio.scene.views[sighting.view];
    const bool nobody = view.stop == 3;                // a stop that no camera sees
    const bool never = view.camera == 2 && view.stop;  // a camera that never sees the table
    const bool sometimes = view.camera == 1 && view.stop == 5;
    if (nobody || never || sometimes) sighting.corners.clear();
  }
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(result->calibration.NumViews(), 24);
  EXPECT_FALSE(result->calibration.rig->model.cam_from_mount[2]);
  EXPECT_NEAR(result->rig->stop_error_sigma[3][kStep], 0.03 * kDegree, 1e-9);  // the prior is all there is
  EXPECT_THAT(result->report.advice, Contains(HasSubstr("camera cam2: never saw the chart at a stop")));
  EXPECT_LT(AxisErrorOf(studio, *result).direction_rad, 0.06 * kDegree);
}

TEST(SeedCameras, WithoutARigTheWorldIsTheBoard) {
  Studio studio = TurntableStudio(10, {.hand_held_per_camera = 10});
  studio.scene.rig.reset();
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  ASSERT_EQ(result->calibration.NumViews(), 66);
  EXPECT_FALSE(result->rig);
  const auto error = PoseDifference(result->calibration.views[40].cam_from_world, studio.cam_from_board[40]);
  EXPECT_LT(error.head<3>().norm(), 0.06 * kDegree);
  EXPECT_LT(error.tail<3>().norm(), 6e-4);
}

void ExpectMountsRecovered(const Studio& studio) {
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.contradictions, IsEmpty());
  Normalised normalised;
  normalised.Collect(studio, *result);
  EXPECT_LT(MomentsOf(normalised.poses).deviation, 1.6);
  EXPECT_LT(MomentsOf(normalised.axis).deviation, 1.6);
  EXPECT_LT(
      PoseDifference(*result->calibration.rig->model.cam_from_mount[0], *studio.truth.rig.cam_from_mount[0]).norm(),
      2e-3);
}

TEST(SeedCameras, RecoversAGantry) {
  ExpectMountsRecovered(GantryStudio(11, PositionerLoad::kCameras));
  ExpectMountsRecovered(GantryStudio(12, PositionerLoad::kObject));
}

TEST(SeedCameras, RecoversAnArm) {
  ExpectMountsRecovered(ArmStudio(13, PositionerLoad::kCameras));
  ExpectMountsRecovered(ArmStudio(14, PositionerLoad::kObject));
}

TEST(SeedCameras, AnArmThatTurnsAboutOneAxisDoesNotDetermineItsHandEye) {
  Studio studio = ArmStudio(19, PositionerLoad::kObject);
  Random random(1);
  const Rigid3d first = *studio.scene.stops[0].base_from_flange;
  for (std::size_t s = 0; s < studio.scene.stops.size(); ++s) {
    const double angle_rad = 2 * kDegree * static_cast<double>(s);
    const Eigen::Vector3d noise = 2e-4 * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    studio.scene.stops[s].base_from_flange = first * Rigid3d{ExpRotation(Eigen::Vector3d(0, 0, angle_rad) + noise), {}};
  }
  const Result<SeedResult> refused = SeedCameras(studio.scene, {}, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("turned about different axes"));
}

TEST(SeedCameras, AnExactGantryIsNoDivisionByZero) {
  Studio studio = GantryStudio(20, PositionerLoad::kCameras);
  studio.scene.rig->axis_scale_sigma = 0;
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  for (int k = 0; k < 2; ++k)
    EXPECT_NEAR(result->calibration.rig->model.positioner.axes_in_stage.col(k).norm(), 1, 1e-6);
}

TEST(SeedCameras, RefusesWhatDoesNotFit) {
  const Studio noisy = TurntableStudio(15, {.num_stops = 6, .hand_held_per_camera = 6, .noise_px = 0.6});
  const Result<SeedResult> refused = SeedCameras(noisy.scene, {}, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("camera cam0"), HasSubstr("0.50 px are allowed"),
                                                      HasSubstr("worst view cam0_")));

  Studio blind = TurntableStudio(16, {.num_stops = 6, .hand_held_per_camera = 6});
  for (ChartSighting& sighting : blind.scene.sightings) {
    if (blind.scene.views[sighting.view].camera == 1) sighting.corners.clear();
  }
  const Result<SeedResult> unseen = SeedCameras(blind.scene, {}, {});
  ASSERT_FALSE(unseen);
  EXPECT_THAT(unseen.error().message, HasSubstr("camera cam1: 0 views"));
}

TEST(SeedCameras, AdvisesWhatToShowNext) {
  Studio studio =
      TurntableStudio(17, {.large_board = true, .num_cameras = 1, .num_stops = 6, .hand_held_per_camera = 3});
  for (ChartSighting& sighting : studio.scene.sightings) {
    std::erase_if(sighting.corners, [](const ChartCorner& corner) { return corner.x_px.x() < 300; });
  }
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_THAT(result->report.advice,
              ElementsAre(testing::AllOf(HasSubstr("camera cam0: upper left corner"), HasSubstr("lower left corner"),
                                         HasSubstr("unseen"), HasSubstr("(9 seen, 10 advised)"))));
}

TEST(SeedCameras, StopsOnRequest) {
  std::stop_source source;
  source.request_stop();
  const Studio studio = TurntableStudio(18, {.num_stops = 4, .hand_held_per_camera = 3});
  const Result<SeedResult> result = SeedCameras(studio.scene, {}, {.stop = source.get_token()});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace rigcal
