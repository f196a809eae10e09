#include "core/adjust/adjust.h"

#include <gtest/gtest.h>

#include "core/base/ensure.h"
#include "core/rig/projection_uncertainty.h"
#include "tests/adjust/synthetic_scene.h"

namespace rigcal {
namespace {

using namespace synthetic;

TEST(Adjust, RecoversARing) {
  const Scene scene = MakeScene(Ring(16), 6, {.sigma_px = 0.3, .outlier_share = 0.05});
  const auto result = scene.Run();
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(TruthErrorPx(scene.truth, scene.seed, scene.surface), 1.5);
  EXPECT_LT(TruthErrorPx(scene.truth, result->calibration, scene.surface), 0.15);
  EXPECT_NEAR(result->report.observation_sigma_px, 0.311, 0.02);  // 0.3 over the root of the Cauchy loss's efficiency
}

TEST(Adjust, RecoversAHemisphereFromTwelvePixels) {
  const Scene scene = MakeScene(Hemisphere(16), 12, {.sigma_px = 0.3, .outlier_share = 0.05});
  const auto result = scene.Run();
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(TruthErrorPx(scene.truth, scene.seed, scene.surface), 3);
  EXPECT_LT(TruthErrorPx(scene.truth, result->calibration, scene.surface), 0.15);
  // 5 % of the features were displaced; those that landed near the truth by chance stay.
  const double offered = result->report.num_observations + result->report.num_dropped_observations;
  EXPECT_NEAR(result->report.num_dropped_observations / offered, 0.05, 0.02);
}

// DESIGN.md section 3, point 5: on a turntable only the prior holds fx / fy.
TEST(Adjust, SingleAxisMotionNeedsTheAspectPrior) {
  Scene scene = MakeScene(Ring(16), 6, {.sigma_px = 0.3});
  const auto held = scene.Run();
  scene.options.camera_priors[0].aspect_sigma = 1;
  scene.options.seed_prior->expected_error_px = 100;
  const auto loose = scene.Run();
  ASSERT_TRUE(held && loose);
  const auto aspect_error = [](const Adjustment& a) {
    return std::abs(a.calibration.cameras[0].fx_px / a.calibration.cameras[0].fy_px - 1);
  };
  EXPECT_LT(aspect_error(*held), 0.003);  // three sigmas of the prior
  EXPECT_GT(aspect_error(*loose), 2 * aspect_error(*held));
  EXPECT_GT(held->report.weakest_directions_px[0], 1);  // the features alone would let it drift by pixels
  const auto sphere = MakeScene(Hemisphere(16), 6, {.sigma_px = 0.3}).Run();
  ASSERT_TRUE(sphere);
  EXPECT_LT(sphere->report.weakest_directions_px[0], 0.1);
}

// Errors that all features share do not average out: four times the features halve the stated sigma only without them.
TEST(Adjust, ASharedErrorKeepsTheStatedSigmaFromFalling) {
  Scene all = MakeScene(Hemisphere(16), 6, {.sigma_px = 0.3});
  Scene quarter = all;
  quarter.tracks.tracks.clear();
  for (std::size_t t = 0; t < all.tracks.tracks.size(); t += 4) quarter.tracks.tracks.push_back(all.tracks.tracks[t]);
  const auto sigma_ratio = [&](double systematic_sigma_px) {
    all.options.noise.systematic_sigma_px = quarter.options.noise.systematic_sigma_px = systematic_sigma_px;
    const auto few = quarter.Run(), many = all.Run();
    Ensure(few && many, "both runs end");
    return std::sqrt(few->calibration.covariance->joint(kFx, kFx) / many->calibration.covariance->joint(kFx, kFx));
  };
  EXPECT_NEAR(sigma_ratio(0), 2.0, 0.3);
  EXPECT_LT(sigma_ratio(0.1), 1.3);
}

TEST(Adjust, KeepsTheSeedsFrameAndScale) {
  Scene scene = MakeScene(Hemisphere(12), 4, {.sigma_px = 0.3});
  const auto reference = scene.Run();
  // The same problem started from cameras in another frame: the seed decides, not the start.
  const Similarity3d elsewhere{1.3, {ExpRotation({0.02, -0.01, 0.03}), {0.01, 0.02, -0.005}}};
  TrackSet tracks = scene.tracks;
  const auto moved = Adjust(InFrame(scene.seed, elsewhere), tracks, scene.ExpectedErrors(), scene.options, {});
  ASSERT_TRUE(reference && moved);
  const auto anchors = ChooseSeedAnchors(*scene.options.seed_prior, scene.tracks);
  const Similarity3d residual = AlignmentToSeed(moved->calibration, anchors);
  EXPECT_NEAR(residual.scale, 1, 1e-9);
  EXPECT_LT(residual.b_from_a.translation.norm(), 1e-9);
  for (int v = 0; v < scene.seed.NumViews(); ++v) {
    const Eigen::Vector3d a = CentreInWorld(reference->calibration.views[v].cam_from_world);
    const Eigen::Vector3d b = CentreInWorld(moved->calibration.views[v].cam_from_world);
    EXPECT_LT((a - b).norm(), 1e-4) << v;  // 0.1 mm at 0.6 m: 0.02 px
  }
}

TEST(Adjust, AShiftOfAllFeaturesMovesThePrincipalPoint) {
  Scene scene = MakeScene(Hemisphere(16), 1, {.sigma_px = 0.01});
  scene.options.camera_priors[0].principal_point_sigma_px = 100;
  const auto before = scene.Run();
  for (Track& track : scene.tracks.tracks) {
    for (Observation& o : track.observations) o.x_px.x() += 0.5;
  }
  const auto after = scene.Run();
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->calibration.cameras[0].cx_px - before->calibration.cameras[0].cx_px, 0.5, 0.1);
  EXPECT_NEAR(after->calibration.cameras[0].cy_px - before->calibration.cameras[0].cy_px, 0, 0.1);
}

TEST(Adjust, FixedViewsAndTheirCameraStayAsTheyAre) {
  Scene scene = MakeScene(Ring(12), 4, {.sigma_px = 0.3});
  scene.options.fixed_views.assign(12, true);
  scene.options.fixed_views[5] = false;
  for (int v = 0; v < 12; ++v) {
    if (v != 5) scene.seed.views[v] = scene.truth.views[v];
  }
  scene.seed.cameras = scene.truth.cameras;
  scene.options.seed_prior->seed = scene.seed;
  const auto result = scene.Run();
  ASSERT_TRUE(result);
  EXPECT_EQ(result->calibration.cameras[0].Intrinsics(), scene.seed.cameras[0].Intrinsics());
  for (int v = 0; v < 12; ++v) {
    const Rigid3d& was = scene.seed.views[v].cam_from_world;
    const Rigid3d& is = result->calibration.views[v].cam_from_world;
    EXPECT_EQ(was.translation == is.translation && was.rotation.coeffs() == is.rotation.coeffs(), v != 5) << v;
    const int row = CalibrationCovariance::PoseRow(1, v);
    EXPECT_EQ(result->calibration.covariance->joint.block(row, row, 6, 6).isZero(0), v != 5) << v;
  }
  EXPECT_LT(TruthErrorPx(scene.truth, result->calibration, scene.surface), 0.05);
}

TEST(Adjust, IntrinsicsPerViewEachHaveTheirPrior) {
  Scene scene = WithCameraPerView(MakeScene(Hemisphere(12), 4, {.sigma_px = 0.3}));
  scene.options.intrinsics = IntrinsicsMode::kPerView;
  const auto result = scene.Run();
  ASSERT_TRUE(result);
  double stated_px = 0;
  for (const double sigma_px :
       ProjectionSigmaPx(result->calibration, ObjectViewPoints(result->calibration, result->tracks, 100))) {
    stated_px += sigma_px / 12;
  }
  EXPECT_LT(stated_px, 0.5);
  EXPECT_LT(TruthErrorPx(scene.truth, result->calibration, scene.surface), 1.5 * stated_px);
  EXPECT_NE(result->calibration.cameras[0].fx_px, result->calibration.cameras[1].fx_px);
  for (int c = 0; c < 12; ++c) {
    const Camera& camera = result->calibration.cameras[c];
    EXPECT_LT(std::abs(camera.fx_px / camera.fy_px - 1), 4 * kAspectSigma);
    EXPECT_LT(std::abs(camera.cx_px - scene.options.camera_priors[c].principal_point_px.x()), 4 * 3.0);
  }
  Scene shared = MakeScene(Hemisphere(4), 4, {});
  shared.options.intrinsics = IntrinsicsMode::kPerView;
  EXPECT_THROW((void)shared.Run(), BrokenPromise);
}

TEST(Adjust, FixedIntrinsicsStay) {
  Scene scene = MakeScene(Ring(8), 3, {.sigma_px = 0.3});
  scene.options.intrinsics = IntrinsicsMode::kFixed;
  const auto result = scene.Run();
  ASSERT_TRUE(result);
  EXPECT_EQ(result->calibration.cameras[0].Intrinsics(), scene.seed.cameras[0].Intrinsics());
}

TEST(Adjust, PaperModeIsPlainLeastSquares) {
  Scene scene = WithCameraPerView(MakeScene(Hemisphere(8), 1, {.sigma_px = 0.3}));
  scene.options.paper = true;
  const auto result = scene.Run();
  ASSERT_TRUE(result);
  // 2 N residuals, 3 a point and 11 a view fitted, 15 of them a projectivity: nothing but the features counts.
  const AdjustReport& report = result->report;
  const double unknowns = 3 * report.num_tracks + 11 * 8 - 15;
  double sum_px2 = 0;
  for (const Track& track : result->tracks.tracks) {
    for (const Observation& o : track.observations) {
      const View& view = result->calibration.views[o.view];
      sum_px2 += (*Project(result->calibration.CameraOf(o.view), view.cam_from_world * track.x_in_world) - o.x_px)
                     .squaredNorm();
    }
  }
  EXPECT_NEAR(std::sqrt(sum_px2 / (2 * report.num_observations - unknowns)), 0.3, 0.015);
  EXPECT_NE(result->calibration.cameras[0].skew_px, 0);
  EXPECT_FALSE(result->calibration.covariance);
  const double expected_px = report.reprojection_mean_px + 3 * report.reprojection_std_px;
  for (const double er_px : report.expected_error_px) EXPECT_DOUBLE_EQ(er_px, expected_px);
  // No prior: another seed, the same result.
  scene.options.seed_prior->seed = scene.truth;
  scene.options.camera_priors[0].aspect = 2;
  EXPECT_EQ(scene.Run()->calibration.cameras[0].fx_px, result->calibration.cameras[0].fx_px);
}

TEST(Adjust, AViewWithoutFeaturesStaysWhereTheSeedSeesIt) {
  Scene scene = MakeScene(Ring(12), 4, {.sigma_px = 0.3});
  for (Track& track : scene.tracks.tracks) {
    std::erase_if(track.observations, [](const Observation& o) { return o.view == 3; });
  }
  const auto result = scene.Run();
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.num_features[3], 0);
  EXPECT_EQ(result->report.expected_error_px[3], scene.expected_error_px);
  double sum_px = 0;
  int count = 0;
  for (const SurfacePoint& point : scene.surface) {
    if (!Faces(scene.seed.views[3].cam_from_world, point)) continue;
    const auto at = [&point](const RigCalibration& rig) {
      return *Project(rig.CameraOf(3), rig.views[3].cam_from_world * point.x_in_world);
    };
    sum_px += (at(result->calibration) - at(scene.seed)).norm();
    ++count;
  }
  EXPECT_LT(sum_px / count, 0.5);  // what a refined focal length cannot give back by moving; the seed is 4 px off
}

TEST(Adjust, ExpectedErrorFallsToTheFloorAndNeverGrows) {
  Scene scene = MakeScene(Ring(8), 6, {.sigma_px = 0.3});
  auto expected = scene.ExpectedErrors();
  expected[2] = 3;
  const auto result = Adjust(scene.seed, scene.tracks, expected, scene.options, {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->report.expected_error_px[1], scene.options.min_expected_error_px);
  EXPECT_EQ(result->report.expected_error_px[2], 3);
  scene.options.min_expected_error_px = 0;
  const auto unfloored = scene.Run();
  ASSERT_TRUE(unfloored);
  EXPECT_NEAR(unfloored->report.expected_error_px[1], 0.9, 0.3);
}

TEST(Adjust, HeldOutTracksAreJudgedNotUsed) {
  Scene scene = MakeScene(Ring(8), 4, {.sigma_px = 0.3}, 1, 600);
  for (std::size_t t = 0; t < scene.tracks.tracks.size(); t += 5) scene.tracks.tracks[t].held_out = true;
  const auto result = scene.Run();
  for (Track& track : scene.tracks.tracks) {
    for (Observation& o : track.observations) o.x_px += Eigen::Vector2d(track.held_out ? 30 : 0, 0);
  }
  const auto displaced = scene.Run();
  ASSERT_TRUE(result && displaced);
  EXPECT_EQ(result->calibration.cameras[0].fx_px, displaced->calibration.cameras[0].fx_px);
  const Track& before = result->tracks.tracks[0];
  ASSERT_TRUE(before.held_out);
  EXPECT_LT((before.x_in_world - *TriangulateTrack(result->calibration, before)).norm(), 1e-12);
  EXPECT_GT((before.x_in_world - displaced->tracks.tracks[0].x_in_world).norm(), 1e-4);
}

TEST(Adjust, SameInSameOut) {
  const Scene scene = MakeScene(Ring(8), 4, {.sigma_px = 0.3, .outlier_share = 0.05}, 1, 600);
  const auto first = scene.Run();
  std::vector<std::vector<double>> other_heap(1000, std::vector<double>(77));  // addresses differ the second time
  const auto second = scene.Run();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->calibration.cameras[0].Intrinsics(), second->calibration.cameras[0].Intrinsics());
  for (int v = 0; v < 8; ++v) {
    const Rigid3d& a = first->calibration.views[v].cam_from_world;
    const Rigid3d& b = second->calibration.views[v].cam_from_world;
    EXPECT_TRUE(a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs()) << v;
  }
  EXPECT_EQ(first->calibration.covariance->joint, second->calibration.covariance->joint);
  EXPECT_EQ(first->report.observation_sigma_px, second->report.observation_sigma_px);
}

TEST(Adjust, StopsOnRequestAndSaysWhenNothingIsLeft) {
  const Scene scene = MakeScene(Ring(6), 4, {.sigma_px = 0.3}, 1, 300);
  std::stop_source stop;
  Execution execution;
  execution.stop = stop.get_token();
  execution.report_progress = [&stop](double) { stop.request_stop(); };
  const auto stopped = Adjust(scene.seed, scene.tracks, scene.ExpectedErrors(), scene.options, execution);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
  const auto empty = Adjust(scene.seed, {}, scene.ExpectedErrors(), scene.options, {});
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::kBadInput);
}

}  // namespace
}  // namespace rigcal
