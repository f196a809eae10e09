#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/rig/rig_model_pose.h"
#include "core/rig/rig_prior.h"
#include "tests/adjust/synthetic_scene.h"

namespace rigcal {
namespace {

using namespace synthetic;
using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

/// An object before a rig that is known from a chart, with its truth.
struct RigScene {
  RigTerms rig;
  RigCalibration start, truth;
  RigState true_state;
  std::vector<SurfacePoint> surface;
  TrackSet tracks;

  [[nodiscard]] Result<Adjustment> Run(AdjustOptions options = {}) const {
    options.rig = rig;
    options.refine_distortion = true;
    return Adjust(start, tracks, std::vector<double>(start.views.size(), 2.0), options, {});
  }
};

struct TurntableOptions {
  int num_cameras = 3, num_points = 300;
  std::uint64_t random_seed = 1;
  double bump_rad = 0;  ///< of the camera `bumped` since the chart
  int bumped = 1;
  double focal_change = 0;  ///< of camera 1 since the chart, a share of itself
  double slip_rad = 0;      ///< of the table at stop 5
  int used_stops = 8;       ///< of 8 that there are
  int blind_view = -1;      ///< sees nothing
};

/// What a chart leaves uncertain: a pixel of lens, a tenth of a millimetre and 0.01 degrees of each mount.
RigPrior PriorOfRig(int num_cameras) {
  RigPrior prior;
  prior.model = Turntable();
  for (int c = 0; c < num_cameras; ++c) {
    Camera camera = StudioCamera();
    camera.id = camera.physical_id = "cam" + std::to_string(c);
    camera.k1 = -0.1;
    prior.cameras.push_back(camera);
    const double elevation_rad = 0.2 + 0.3 * c, azimuth_rad = 0.2 * c;
    const Eigen::Vector3d direction(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                    std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad));
    prior.model.cam_from_mount.emplace_back(LookingAtOrigin(kDistance_m * direction));
  }
  const int size = RigCovariance::Size(num_cameras);
  prior.covariance.joint = Eigen::MatrixXd::Zero(size, size);
  auto variance = prior.covariance.joint.diagonal();
  for (int c = 0; c < num_cameras; ++c) {
    variance.segment<4>(RigCovariance::IntrinsicsRow(c)).setConstant(1);
    variance[RigCovariance::IntrinsicsRow(c) + kK1] = 1e-4;
    LoosenMount(c, 2e-4, 1e-4, prior);
  }
  return prior;
}

/// Truth drawn from the priors; the start is the rig without error.
RigScene MakeTurntable(const TurntableOptions& options) {
  Random random(options.random_seed);
  RigScene scene;
  RigTerms& rig = scene.rig;
  rig.prior = PriorOfRig(options.num_cameras);
  scene.true_state.model = rig.prior.model;
  constexpr int kNumStops = 8;
  for (int s = 0; s < kNumStops; ++s) {
    rig.stops.push_back({std::to_string(s), {2 * std::numbers::pi * s / kNumStops}, std::nullopt});
    StopError& error = scene.true_state.stop_errors.emplace_back(rig.prior.model.error_sigma);
    for (double& component : error) component *= random.Normal();
    if (s == 5) error[kStep] += options.slip_rad;
  }
  rig.stop_error_sigma.assign(rig.stops.size(), rig.prior.model.error_sigma);
  rig.start = {rig.prior.model, std::vector(rig.stops.size(), StopError(StopError::Zero()))};
  scene.start.cameras = scene.truth.cameras = rig.prior.cameras;
  for (int c = 0; c < options.num_cameras; ++c) {
    const Eigen::VectorXd sigma = rig.prior.covariance.joint.diagonal().cwiseSqrt();
    IntrinsicVector intrinsics = rig.prior.cameras[c].Intrinsics();
    for (int k = 0; k < kNumIntrinsics; ++k)
      intrinsics[k] += random.Normal() * sigma[RigCovariance::IntrinsicsRow(c) + k];
    if (c == 1) intrinsics.head<2>() *= 1 + options.focal_change;
    scene.truth.cameras[c].SetIntrinsics(intrinsics);
    Eigen::Matrix<double, 6, 1> moved;
    for (int k = 0; k < 6; ++k) moved[k] = random.Normal() * sigma[RigCovariance::MountRow(options.num_cameras, c) + k];
    if (c == options.bumped) moved[1] += options.bump_rad;
    auto& mount = scene.true_state.model.cam_from_mount[c];
    mount = Disturbed(*mount, moved);
    for (int s = 0; s < options.used_stops; ++s) {
      rig.stop_of_view.push_back(s);
      scene.start.views.push_back({"cam" + std::to_string(c) + "_" + std::to_string(s), c, {}});
    }
  }
  scene.truth.views = scene.start.views;
  PlaceViews(rig.start.model, rig.stops, rig.start.stop_errors, rig.stop_of_view, scene.start);
  PlaceViews(scene.true_state.model, rig.stops, scene.true_state.stop_errors, rig.stop_of_view, scene.truth);
  scene.surface = Surface(options.num_points, random);
  scene.tracks = Observe(scene.truth, scene.surface, {.sigma_px = 0.3, .outlier_share = 0.02}, random);
  for (Track& track : scene.tracks.tracks) {
    std::erase_if(track.observations, [&](const Observation& o) { return o.view == options.blind_view; });
  }
  std::erase_if(scene.tracks.tracks, [](const Track& track) { return track.observations.size() < 2; });
  return scene;
}

/// A camera on an arm over the object: hand and eye known from a chart, flange poses as an arm repeats them.
RigScene MakeArm(std::uint64_t random_seed) {
  Random random(random_seed);
  RigScene scene;
  RigTerms& rig = scene.rig;
  const RigCalibration ideal = Hemisphere(14);
  rig.prior.cameras = ideal.cameras;
  rig.prior.model = Arm(PositionerLoad::kCameras);
  rig.prior.model.cam_from_mount = {Rigid3d{ExpRotation({0.2, -0.1, 1.0}), {0.03, -0.05, 0.1}}};
  rig.prior.model.positioner.anchor_from_world = {ExpRotation({0.1, 0.3, -0.2}), {0.4, -0.2, 0.3}};
  rig.prior.covariance.joint = Eigen::MatrixXd::Zero(RigCovariance::Size(1), RigCovariance::Size(1));
  rig.prior.covariance.joint.diagonal().head<4>().setConstant(1);
  LoosenMount(0, 5e-4, 5e-4, rig.prior);
  rig.prior.covariance.joint.diagonal().segment<3>(RigCovariance::AnchorRow(1)).setConstant(25e-8);
  rig.prior.covariance.joint.diagonal().segment<3>(RigCovariance::AnchorRow(1) + 3).setConstant(25e-8);
  const Eigen::VectorXd sigma = rig.prior.covariance.joint.diagonal().cwiseSqrt();
  const auto drawn = [&](int row) {
    Eigen::Matrix<double, 6, 1> delta;
    for (int k = 0; k < 6; ++k) delta[k] = random.Normal() * sigma[row + k];
    return delta;
  };
  RigModel& truth = scene.true_state.model = rig.prior.model;
  truth.cam_from_mount[0] = Disturbed(*truth.cam_from_mount[0], drawn(RigCovariance::MountRow(1, 0)));
  truth.positioner.anchor_from_world =
      Disturbed(truth.positioner.anchor_from_world, drawn(RigCovariance::AnchorRow(1)));
  for (int v = 0; v < ideal.NumViews(); ++v) {
    const Rigid3d base_from_flange = rig.prior.model.positioner.anchor_from_world *
                                     ideal.views[v].cam_from_world.Inverse() * *rig.prior.model.cam_from_mount[0];
    rig.stops.push_back({std::to_string(v), {}, base_from_flange});
    rig.stop_of_view.push_back(v);
    StopError& error = scene.true_state.stop_errors.emplace_back(rig.prior.model.error_sigma);
    for (double& component : error) component *= random.Normal();
  }
  rig.stop_error_sigma.assign(rig.stops.size(), rig.prior.model.error_sigma);
  rig.start = {rig.prior.model, std::vector(rig.stops.size(), StopError(StopError::Zero()))};
  scene.start = scene.truth = ideal;
  PlaceViews(rig.start.model, rig.stops, rig.start.stop_errors, rig.stop_of_view, scene.start);
  PlaceViews(truth, rig.stops, scene.true_state.stop_errors, rig.stop_of_view, scene.truth);
  scene.surface = Surface(300, random);
  scene.tracks = Observe(scene.truth, scene.surface, {.sigma_px = 0.3, .outlier_share = 0.02}, random);
  return scene;
}

TEST(AdjustRig, AnArmsHandAndEyeAreFoundToTheirStatedSigma) {
  double sum2 = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const RigScene scene = MakeArm(seed);
    const auto adjusted = scene.Run();
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    EXPECT_LT(TruthErrorPx(scene.truth, adjusted->calibration, scene.surface), 0.1) << seed;
    EXPECT_THAT(adjusted->rig->contradictions, ::testing::IsEmpty()) << seed;
    const RigPrior truth{scene.truth.cameras, scene.true_state.model, {}};
    const Eigen::VectorXd off = DepartureFrom(truth, adjusted->calibration.cameras, adjusted->rig->state.model);
    const Eigen::VectorXd variance = adjusted->calibration.rig->covariance.joint.diagonal();
    for (int row = RigCovariance::MountRow(1, 0); row < RigCovariance::AxesRow(1); ++row) {
      ASSERT_GT(variance[row], 0) << row;
      sum2 += off[row] * off[row] / variance[row], ++count;
    }
  }
  const double deviation = std::sqrt(sum2 / count);
  RecordProperty("deviation", std::to_string(deviation));
  EXPECT_GT(deviation, 0.7);  // 72 numbers: 1 +- 0.09 when independent
  EXPECT_LT(deviation, 1.35);
}

TEST(AdjustRig, IsNearerToTheTruthThanFreePosesAndThanTheStart) {
  const RigScene scene = MakeTurntable({});
  const auto rig = scene.Run();
  ASSERT_TRUE(rig) << rig.error().message;
  AdjustOptions options;
  options.seed_prior = SeedPrior{scene.start, 2.0};
  options.camera_priors = PriorsOf(scene.start, 0.001);
  const auto free = Adjust(scene.start, scene.tracks, std::vector<double>(scene.start.views.size(), 2.0), options, {});
  ASSERT_TRUE(free) << free.error().message;
  const double before_px = TruthErrorPx(scene.truth, scene.start, scene.surface);
  const double rig_px = TruthErrorPx(scene.truth, rig->calibration, scene.surface);
  const double free_px = TruthErrorPx(scene.truth, free->calibration, scene.surface);
  RecordProperty("before_px", std::to_string(before_px));
  RecordProperty("rig_px", std::to_string(rig_px));
  RecordProperty("free_px", std::to_string(free_px));
  EXPECT_LT(rig_px, 0.1 * before_px);
  EXPECT_LT(rig_px, free_px);
  EXPECT_THAT(rig->rig->contradictions, ::testing::IsEmpty());
}

TEST(AdjustRig, PosesFollowFromTheRig) {
  const RigScene scene = MakeTurntable({});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  RigCalibration placed = adjusted->calibration;
  const RigState& state = adjusted->rig->state;
  PlaceViews(state.model, scene.rig.stops, state.stop_errors, scene.rig.stop_of_view, placed);
  EXPECT_LT(Difference(placed, adjusted->calibration).norm(), 1e-12);
  EXPECT_EQ(state.stop_errors[3][kLift], 0);  // the rig says: exact
  ASSERT_TRUE(adjusted->calibration.rig);
  EXPECT_EQ(adjusted->calibration.rig->covariance.joint.rows(), RigCovariance::Size(3));
}

TEST(AdjustRig, AViewThatSeesNothingStillGetsItsPose) {
  const RigScene scene = MakeTurntable({.blind_view = 10});  // camera 1, stop 2
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->report.num_features[10], 0);
  // Against the stop before: where the world lies is the prior's.
  const auto turn = [](const RigCalibration& calibration) {
    return (calibration.views[10].cam_from_world * calibration.views[9].cam_from_world.Inverse()).rotation;
  };
  EXPECT_LT(turn(adjusted->calibration).angularDistance(turn(scene.truth)), 0.01 * kDegree);
}

TEST(AdjustRig, NamesTheCameraThatMoved) {
  const RigScene scene = MakeTurntable({.bump_rad = 0.5 * kDegree});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->rig->contradictions.size(), 1u);
  EXPECT_THAT(adjusted->rig->contradictions[0], HasSubstr("camera cam1 moved"));
  EXPECT_THAT(adjusted->rig->contradictions[0], ::testing::Not(HasSubstr("focus")));
  EXPECT_LT(TruthErrorPx(scene.truth, adjusted->calibration, scene.surface), 0.1);
}

TEST(AdjustRig, NamesTheStopThatSlipped) {
  const RigScene scene = MakeTurntable({.slip_rad = 1 * kDegree});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->rig->contradictions.size(), 1u);
  EXPECT_THAT(adjusted->rig->contradictions[0], HasSubstr("stop 5: step error"));
  EXPECT_LT(TruthErrorPx(scene.truth, adjusted->calibration, scene.surface), 0.1);
}

TEST(AdjustRig, NamesBothFaultsAtOnce) {
  const RigScene scene = MakeTurntable({.bump_rad = 0.5 * kDegree, .slip_rad = 1 * kDegree});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_THAT(adjusted->rig->contradictions,
              ::testing::UnorderedElementsAre(HasSubstr("camera cam1 moved"), HasSubstr("stop 5: step error")));
  EXPECT_FALSE(adjusted->rig->scale_is_lost);
}

TEST(AdjustRig, SaysThatAChangeOfFocusLooksLikeAMove) {
  const RigScene scene = MakeTurntable({.focal_change = 0.01});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_THAT(adjusted->rig->contradictions,
              ::testing::ElementsAre(::testing::AllOf(HasSubstr("camera cam1 moved"), HasSubstr("change of focus"))));
}

TEST(AdjustRig, WithoutACameraInItsPlaceNothingTellsLengths) {
  const RigScene scene = MakeTurntable({.num_cameras = 1, .bump_rad = 0.5 * kDegree, .bumped = 0});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->rig->scale_is_lost);
  EXPECT_THAT(adjusted->rig->contradictions, ::testing::Contains(HasSubstr("show the chart again")));
}

TEST(AdjustRig, StopsThatNothingShowsHaveNoSay) {
  // Half of the stops are in the recording for the chart's sake alone.
  const RigScene scene = MakeTurntable({.slip_rad = 1 * kDegree, .used_stops = 6});
  const auto adjusted = scene.Run();
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->rig->contradictions.size(), 1u);
  EXPECT_THAT(adjusted->rig->contradictions[0], HasSubstr("stop 5: step error of"));
}

TEST(AdjustRig, ALensThatIsHeldLeavesTheRigAsItWasKnown) {
  const RigScene scene = MakeTurntable({});
  const auto adjusted = scene.Run({.intrinsics = IntrinsicsMode::kFixed});
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->calibration.cameras[0].fx_px, scene.start.cameras[0].fx_px);
  EXPECT_EQ(adjusted->calibration.rig->covariance.joint, scene.rig.prior.covariance.joint);
  EXPECT_EQ(adjusted->calibration.covariance->joint(kFx, kFx), 0);
}

TEST(AdjustRig, StatesItsUncertaintyHonestly) {
  double sum = 0, sum2 = 0;
  int count = 0;
  const auto add = [&](double error, double sigma) {
    if (sigma == 0) return;
    sum += error / sigma, sum2 += error * error / (sigma * sigma), ++count;
  };
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const RigScene scene = MakeTurntable({.num_points = 150, .random_seed = seed});
    const auto adjusted = scene.Run();
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    EXPECT_THAT(adjusted->rig->contradictions, ::testing::IsEmpty()) << seed;
    const Eigen::MatrixXd& joint = adjusted->calibration.covariance->joint;
    const Eigen::VectorXd error = Difference(adjusted->calibration, scene.truth);
    for (int row = 0; row < error.size(); ++row) add(error[row], std::sqrt(joint(row, row)));
    const RigPrior truth{scene.truth.cameras, scene.true_state.model, {}};
    const Eigen::VectorXd of_rig = DepartureFrom(truth, adjusted->calibration.cameras, adjusted->rig->state.model);
    const Eigen::VectorXd variance = adjusted->calibration.rig->covariance.joint.diagonal();
    for (int row = 0; row < of_rig.size(); ++row) add(of_rig[row], std::sqrt(variance[row]));
    for (std::size_t s = 0; s < scene.rig.stops.size(); ++s) {
      for (int k = 0; k < kStopErrorSize; ++k) {
        add(adjusted->rig->state.stop_errors[s][k] - scene.true_state.stop_errors[s][k],
            adjusted->rig->stop_error_sigma[s][k]);
      }
    }
  }
  const double mean = sum / count, deviation = std::sqrt(sum2 / count - mean * mean);
  RecordProperty("mean", std::to_string(mean));
  RecordProperty("deviation", std::to_string(deviation));
  EXPECT_LT(std::abs(mean), 0.3);
  EXPECT_GT(deviation, 0.8);
  EXPECT_LT(deviation, 1.25);
}

}  // namespace
}  // namespace rigcal
