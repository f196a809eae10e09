#include "core/match/match_sparse.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/match/link_tracks.h"
#include "tests/match/synthetic_plane.h"

namespace rigcal {
namespace {

const test::PlaneScene& Scene() {
  static const test::PlaneScene scene =
      test::RenderPlane(test::WaveTexture(6.0, 40.0, 0.15, 8),
                        {test::LookAtOrigin("a", 1000, 0, 0), test::LookAtOrigin("b", 1000, 0.25, 0.05),
                         test::LookAtOrigin("c", 1100, -0.2, 0.2, 0.3), test::LookAtOrigin("d", 1000, 0.05, -0.25)},
                        {320, 240}, 3);
  return scene;
}

/// Cameras turned about their own axes by about error_px in the picture, each in its own direction.
RigCalibration Disturb(RigCalibration calibration, double error_px, std::uint64_t seed) {
  Random random(seed);
  for (View& view : calibration.views) {
    const Eigen::Vector3d w = Eigen::Vector3d(random.Normal(), random.Normal(), 0).normalized();
    Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
    delta.head<3>() = w * (error_px / calibration.cameras[0].fx_px);
    view.cam_from_world = Disturbed(view.cam_from_world, delta);
  }
  return calibration;
}

SparseMatchOptions Options(double expected_error_px) {
  SparseMatchOptions options;
  options.expected_error_px.assign(Scene().truth.views.size(), expected_error_px);
  return options;
}

TEST(MatchSparse, FindsTracksWithRoughCameras) {
  const auto set = MatchSparse(Scene().images, Disturb(Scene().truth, 6, 1), Options(7), {});
  ASSERT_TRUE(set.has_value());
  ASSERT_GT(set->tracks.size(), 100u);
  std::vector<double> errors;
  for (const Track& track : set->tracks) {
    EXPECT_EQ(track.source, TrackSource::kSparse);
    std::set<int> views;
    const Observation& first = track.observations[0];
    for (const Observation& o : track.observations) {
      EXPECT_TRUE(views.insert(o.view).second);
      errors.push_back((o.x_px - test::TransferOverPlane(Scene().truth, first.view, first.x_px, o.view)).norm());
    }
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.3);
  EXPECT_LT(errors[errors.size() * 97 / 100], 2.0);
}

TEST(MatchSparse, RespectsTheExpectedError) {
  const RigCalibration off = Disturb(Scene().truth, 20, 1);
  const auto narrow = MatchSparse(Scene().images, off, Options(1), {});
  const auto wide = MatchSparse(Scene().images, off, Options(20), {});
  ASSERT_TRUE(narrow.has_value() && wide.has_value());
  EXPECT_LT(narrow->tracks.size(), wide->tracks.size() / 2);
}

TEST(MatchSparse, SameTracksOnOneAndTwoThreads) {
  Execution two_threads;
  two_threads.num_threads = 2;
  const auto one = MatchSparse(Scene().images, Scene().truth, Options(3), {});
  const auto two = MatchSparse(Scene().images, Scene().truth, Options(3), two_threads);
  ASSERT_TRUE(one.has_value() && two.has_value());
  ASSERT_EQ(one->tracks.size(), two->tracks.size());
  for (std::size_t i = 0; i < one->tracks.size(); ++i) {
    EXPECT_EQ(one->tracks[i].x_in_world, two->tracks[i].x_in_world);
    ASSERT_EQ(one->tracks[i].observations.size(), two->tracks[i].observations.size());
    EXPECT_EQ(one->tracks[i].observations[0].x_px, two->tracks[i].observations[0].x_px);
  }
}

TEST(MatchSparse, StopsOnRequest) {
  std::stop_source source;
  source.request_stop();
  Execution execution;
  execution.stop = source.get_token();
  const auto tracks = MatchSparse(Scene().images, Scene().truth, Options(3), execution);
  ASSERT_FALSE(tracks.has_value());
  EXPECT_EQ(tracks.error().code, ErrorCode::kCancelled);
}

SiftFeatures Places(int count) {
  SiftFeatures features;
  for (int i = 0; i < count; ++i) {
    features.x_px.emplace_back(10 * i, 0);
    features.place.push_back(i);
  }
  features.num_places = count;
  return features;
}

TEST(LinkTracks, DropsChainsThatContradictThemselves) {
  const std::vector<SiftFeatures> features = {Places(2), Places(2), Places(2)};
  // 0-0-0 is one chain; 1-1 and 1-0' would join it through view 2: a second chain that meets view 0 twice.
  const auto good = LinkTracks(features, {{0, 1, {{0, 0, 1.f}, {1, 1, 1.f}}}, {1, 2, {{0, 0, 1.f}}}});
  ASSERT_EQ(good.size(), 2u);
  EXPECT_EQ(good[0].size(), 3u);
  EXPECT_EQ(good[1].size(), 2u);
  const auto contradicting =
      LinkTracks(features, {{0, 1, {{0, 0, 1.f}}}, {1, 2, {{0, 0, 1.f}}}, {0, 2, {{1, 0, 1.f}}}});
  EXPECT_TRUE(contradicting.empty());
}

TEST(EstimateExpectedError, IsConservativeButNotWild) {
  for (const double error_px : {3.0, 6.0, 12.0}) {
    const auto estimate = EstimateExpectedError(Scene().images, Disturb(Scene().truth, error_px, 3), {});
    ASSERT_TRUE(estimate.has_value());
    EXPECT_FALSE(estimate->assumed);
    EXPECT_GT(estimate->num_matches, 200);
    EXPECT_GT(estimate->overall_px, 0.9 * error_px);
    EXPECT_LT(estimate->overall_px, 2.0 * error_px);
  }
}

TEST(EstimateExpectedError, IsSmallForGoodCameras) {
  const auto estimate = EstimateExpectedError(Scene().images, Scene().truth, {});
  ASSERT_TRUE(estimate.has_value());
  EXPECT_LE(estimate->overall_px, 1.0);
}

TEST(EstimateExpectedError, PointsAtTheViewThatIsOff) {
  RigCalibration one_off = Scene().truth;
  Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
  delta[0] = 0.03;  // 30 px
  one_off.views[2].cam_from_world = Disturbed(one_off.views[2].cam_from_world, delta);
  const auto estimate = EstimateExpectedError(Scene().images, one_off, {});
  ASSERT_TRUE(estimate.has_value());
  const auto worst = std::max_element(estimate->per_view_px.begin(), estimate->per_view_px.end());
  EXPECT_EQ(worst - estimate->per_view_px.begin(), 2);
}

TEST(EstimateExpectedError, SaysWhenThePicturesDoNotTell) {
  test::PlaneScene scene = Scene();
  for (ViewImages& view : scene.images.views) view.gray = BuildPyramid(cv::Mat1f(240, 320, 0.2f), 3);
  const auto estimate = EstimateExpectedError(scene.images, scene.truth, {});
  ASSERT_TRUE(estimate.has_value());
  EXPECT_TRUE(estimate->assumed);
  EXPECT_EQ(estimate->overall_px, kAssumedErrorPx);
  EXPECT_EQ(estimate->per_view_px.size(), 4u);
}

}  // namespace
}  // namespace rigcal
