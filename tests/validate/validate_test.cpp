#include "core/validate/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/validate/cameras_for_test.h"
#include "tests/validate/object_scene.h"

namespace rigcal {
namespace {

using test::BendEntries;
using test::Bent;
using test::BentAs;
using test::MakeScene;
using test::Motion;
using test::ObjectScene;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kErPx = 7;

ValidationInput Judging(const ObjectScene& scene) {
  ValidationInput input;
  input.calibration = scene.truth;
  input.tracks = scene.tracks;
  return input;
}

ValidationReport Judged(const ValidationInput& input) {
  const auto report = Validate(input, {});
  EXPECT_TRUE(report.has_value()) << (report ? "" : report.error().message);
  return report.value_or(ValidationReport{});
}

std::vector<std::string> ChecksOf(const ValidationReport& report) {
  std::vector<std::string> checks;
  for (const Reason& r : report.reasons) checks.push_back(r.check);
  return checks;
}

std::vector<std::string> ViewsNamedBy(const ValidationReport& report, const std::string& check) {
  std::vector<std::string> views;
  for (const Reason& r : report.reasons) {
    if (r.check == check) views.push_back(r.view.value_or("none"));
  }
  return views;
}

/// The view's camera turned so far that its picture shifts by about shift_px.
void TurnView(RigCalibration* calibration, int view, double shift_px) {
  Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
  delta[0] = delta[1] = shift_px / (std::sqrt(2.0) * calibration->CameraOf(view).fx_px);
  calibration->views[view].cam_from_world = Disturbed(calibration->views[view].cam_from_world, delta);
}

void KeepFeatures(TrackSet* tracks, const std::function<bool(std::size_t, const Observation&)>& keep) {
  for (std::size_t t = 0; t < tracks->tracks.size(); ++t) {
    std::erase_if(tracks->tracks[t].observations, [&](const Observation& o) { return !keep(t, o); });
  }
  std::erase_if(tracks->tracks, [](const Track& track) { return track.observations.size() < 2; });
}

class GoodCameras : public ::testing::TestWithParam<Motion> {};

TEST_P(GoodCameras, AreAccepted) {
  const ObjectScene scene = MakeScene({.motion = GetParam(), .noise_px = 0.3, .random_seed = 11});
  ValidationInput input = Judging(scene);
  input.prior = scene.truth;
  for (int j = 0; j < input.prior->NumViews(); ++j) TurnView(&*input.prior, j, j % 2 == 0 ? 5 : -5);
  input.expected_error_px = kErPx;
  input.sharpness.assign(scene.truth.views.size(), 0.5);
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kAccepted);
  EXPECT_THAT(ChecksOf(report), IsEmpty());
  EXPECT_GT(report.holdout.before_px.value(), 2);
  EXPECT_LT(report.holdout.after_px, 0.8);
  ASSERT_EQ(report.views.size(), scene.truth.views.size());
  EXPECT_GT(report.views[0].num_features, 30);
  EXPECT_GT(report.views[0].residual_px, 0.1);
}
INSTANTIATE_TEST_SUITE_P(Motions, GoodCameras,
                         ::testing::Values(Motion::kTurntable, Motion::kHemisphere, Motion::kTwoCameraTurntable));

class BentCameras : public ::testing::TestWithParam<std::tuple<BentAs, BendEntries>> {};

TEST_P(BentCameras, AreNeverAccepted) {
  const auto [as, entries] = GetParam();
  for (const double error_px : {2.0, 10.0}) {
    const ObjectScene scene = MakeScene({.motion = Motion::kTurntable, .random_seed = 5});
    ValidationInput input = Judging(scene);
    input.calibration = Bent(scene.truth, scene.points, error_px, as, entries, 17);
    ASSERT_NEAR(test::ErrorPx(scene.truth, input.calibration, scene.points), error_px, 0.3 * error_px);
    const ValidationReport report = Judged(input);
    EXPECT_EQ(report.verdict, Verdict::kRejected);
    if (as == BentAs::kCamerasPerView) {
      EXPECT_LT(report.holdout.after_px, 0.8) << "the bending is not to be seen here";
    }
    EXPECT_THAT(ChecksOf(report), Contains("bend"));
  }
}
INSTANTIATE_TEST_SUITE_P(Ways, BentCameras,
                         ::testing::Combine(::testing::Values(BentAs::kCamerasPerView, BentAs::kSharedCameras),
                                            ::testing::Values(BendEntries::kAll, BendEntries::kAffine)));

TEST(Validate, AspectOfPublishedCamerasPasses) {
  ObjectScene scene = MakeScene({});
  scene.truth.cameras[0].fx_px *= 0.9944;  // the farthest of the published ones
  scene.tracks = test::MeasuredTracks(scene.truth, scene.points, {});
  EXPECT_THAT(ChecksOf(Judged(Judging(scene))), IsEmpty());
}

TEST(Validate, AspectFarFromItsPriorRejects) {
  ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  CameraPrior prior;
  prior.aspect = 1.004;
  prior.aspect_sigma = 0.001;
  prior.principal_point_px = {645, 505};
  input.camera_priors = {prior};
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kRejected);
  EXPECT_THAT(ChecksOf(report), Contains("aspect"));
  EXPECT_NEAR(report.reasons[0].value, 0.004, 1e-9);
  EXPECT_NEAR(report.reasons[0].limit, 0.003, 1e-9);
  EXPECT_EQ(report.reasons[0].camera, "cam0");
}

TEST(Validate, PrincipalPointFarFromItsPriorRejects) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  CameraPrior prior;
  prior.principal_point_px = {645 + 20, 505};
  input.camera_priors = {prior};
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kRejected);
  EXPECT_THAT(ChecksOf(report), ElementsAre("principal_point"));
}

TEST(Validate, SkewRejects) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.calibration.cameras[0].skew_px = 0.05;
  EXPECT_THAT(ChecksOf(Judged(input)), ElementsAre("skew"));
}

TEST(Validate, SpreadOfOneCamerasIntrinsicsRejects) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.calibration.cameras.clear();
  for (int j = 0; j < scene.truth.NumViews(); ++j) {
    Camera camera = scene.truth.cameras[0];
    camera.id += "_" + scene.truth.views[j].name;
    camera.cx_px += j % 2 == 0 ? 30 : -30;
    input.calibration.cameras.push_back(camera);
    input.calibration.views[j].camera = j;
    TurnView(&input.calibration, j, 0);
  }
  EXPECT_THAT(ChecksOf(Judged(input)), Contains("principal_point_spread"));
}

TEST(Validate, TooFewTracksAreInconclusive) {
  ObjectScene scene = MakeScene({.num_views = 8});
  scene.tracks.tracks.resize(60);
  const ValidationReport report = Judged(Judging(scene));
  EXPECT_EQ(report.verdict, Verdict::kInconclusive);
  EXPECT_THAT(ChecksOf(report), Contains("num_tracks"));
}

TEST(Validate, NothingMeasuredIsInconclusive) {
  ObjectScene scene = MakeScene({});
  scene.tracks.tracks.clear();
  const ValidationReport report = Judged(Judging(scene));
  EXPECT_EQ(report.verdict, Verdict::kInconclusive);
  EXPECT_EQ(ViewsNamedBy(report, "view_support").size(), scene.truth.views.size());
}

TEST(Validate, ViewWithoutSupportIsNamed) {
  ObjectScene scene = MakeScene({});
  KeepFeatures(&scene.tracks, [](std::size_t t, const Observation& o) { return o.view != 4 || t % 40 == 0; });
  const ValidationReport report = Judged(Judging(scene));
  EXPECT_EQ(report.verdict, Verdict::kInconclusive);
  EXPECT_THAT(ChecksOf(report), ElementsAre("view_support"));
  EXPECT_THAT(ViewsNamedBy(report, "view_support"), ElementsAre("view04"));
}

TEST(Validate, GroupsWithoutCommonTracksAreInconclusive) {
  ObjectScene scene = MakeScene({});
  KeepFeatures(&scene.tracks, [](std::size_t t, const Observation& o) { return (o.view < 14) == (t % 2 == 0); });
  const ValidationReport report = Judged(Judging(scene));
  EXPECT_EQ(report.verdict, Verdict::kInconclusive);
  EXPECT_THAT(ChecksOf(report), ElementsAre("view_connection"));
  EXPECT_THAT(ViewsNamedBy(report, "view_connection"), ElementsAre("view14"));
}

TEST(Validate, WrongViewsAreNamedAndNoOthers) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  TurnView(&input.calibration, 7, 4);
  const ValidationReport one = Judged(input);
  EXPECT_EQ(one.verdict, Verdict::kRejected);
  EXPECT_THAT(ViewsNamedBy(one, "view_residual"), ElementsAre("view07"));
  TurnView(&input.calibration, 7, 60);
  TurnView(&input.calibration, 15, 20);
  EXPECT_THAT(ViewsNamedBy(Judged(input), "view_residual"), ElementsAre("view07", "view15"));
}

TEST(Validate, SwappedViewsAreNamed) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  std::swap(input.calibration.views[3].cam_from_world, input.calibration.views[5].cam_from_world);
  const auto named = ViewsNamedBy(Judged(input), "view_residual");
  EXPECT_THAT(named, Contains("view03"));
  EXPECT_THAT(named, Contains("view05"));
}

TEST(Validate, LargeHoldoutErrorRejects) {
  ObjectScene scene = MakeScene({.noise_px = 1.0, .outlier_share = 0});
  const ValidationReport report = Judged(Judging(scene));
  EXPECT_EQ(report.verdict, Verdict::kRejected);
  EXPECT_THAT(ChecksOf(report), Contains("holdout_error"));
  EXPECT_NEAR(report.holdout.after_px, 1.4, 0.3);  // 1.25 sigma, and the others' share
}

TEST(Validate, WorseThanBeforeRejects) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.prior = scene.truth;
  input.expected_error_px = kErPx;
  for (int j = 0; j < scene.truth.NumViews(); ++j) TurnView(&input.calibration, j, j % 2 == 0 ? 0.3 : -0.3);
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kRejected);
  EXPECT_THAT(ChecksOf(report), ElementsAre("holdout_error_against_before"));
}

TEST(Validate, ViewFarFromItsPriorIsNamedWithItsDirection) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.prior = scene.truth;
  input.expected_error_px = kErPx;
  input.prior->views[9].cam_from_world = Disturbed(
      input.prior->views[9].cam_from_world, (Eigen::Matrix<double, 6, 1>() << 0, 30.0 / 1800, 0, 0, 0, 0).finished());
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kRejected);
  EXPECT_THAT(ChecksOf(report), ElementsAre("view_distance_from_prior"));
  EXPECT_THAT(ViewsNamedBy(report, "view_distance_from_prior"), ElementsAre("view09"));
  EXPECT_NEAR(report.views[9].moved_px, 30, 1);
  // Turned about +y the prior's picture lies to the right of the judged one: the view moved to the left.
  EXPECT_LT(report.views[9].direction.x(), -0.99);
  EXPECT_LT(report.views[0].moved_px, 1);
}

TEST(Validate, AllViewsFarFromThePriorReject) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.prior = Bent(scene.truth, scene.points, 20, BentAs::kCamerasPerView, BendEntries::kAffine, 3);
  input.expected_error_px = kErPx;
  EXPECT_THAT(ChecksOf(Judged(input)), Contains("distance_from_prior"));
}

TEST(Validate, LargeStatedUncertaintyIsInconclusive) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  const int size = CalibrationCovariance::PoseRow(1, scene.truth.NumViews());
  CalibrationCovariance covariance{Eigen::MatrixXd::Identity(size, size) * 1e-12};
  const int row = CalibrationCovariance::PoseRow(1, 6);
  covariance.joint(row, row) = 4e-6;  // 2 mrad: 3.6 px
  input.calibration.covariance = covariance;
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kInconclusive);
  EXPECT_THAT(ViewsNamedBy(report, "sigma"), ElementsAre("view06"));
  EXPECT_NEAR(report.views[6].sigma_px, 3.6, 0.4);
}

TEST(Validate, BlurredViewIsNamed) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.sharpness.assign(scene.truth.views.size(), 0.7);
  input.sharpness[8] = 0.3;
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kInconclusive);
  EXPECT_THAT(ChecksOf(report), ElementsAre("view_sharpness"));
  EXPECT_THAT(ViewsNamedBy(report, "view_sharpness"), ElementsAre("view08"));
}

TEST(Validate, CamerasThatAreNoNumbersReject) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  input.calibration.views[2].cam_from_world.translation.x() = std::numeric_limits<double>::quiet_NaN();
  const ValidationReport report = Judged(input);
  EXPECT_EQ(report.verdict, Verdict::kRejected);
  EXPECT_THAT(ViewsNamedBy(report, "camera_is_finite"), ElementsAre("view02"));
}

TEST(Validate, TracksOfCamerasFromElsewhereNeedNoMarks) {
  ObjectScene scene = MakeScene({.held_out_share = 0});
  const ValidationReport report = Judged(Judging(scene));
  EXPECT_EQ(report.verdict, Verdict::kAccepted);
  EXPECT_EQ(report.holdout.num_tracks, static_cast<int>(scene.tracks.tracks.size()));
}

TEST(Validate, SaysTheSameTwiceAndStopsOnRequest) {
  const ObjectScene scene = MakeScene({});
  ValidationInput input = Judging(scene);
  EXPECT_EQ(Judged(input).holdout.after_px, Judged(input).holdout.after_px);
  std::stop_source source;
  source.request_stop();
  const auto stopped = Validate(input, {.stop = source.get_token(), .num_threads = 1, .report_progress = {}});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace rigcal
