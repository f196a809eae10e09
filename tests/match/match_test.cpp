#include "core/match/match.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"
#include "core/image/undistort.h"
#include "core/match/patch_frame.h"
#include "core/match/window_fit.h"
#include "tests/match/synthetic_plane.h"

namespace rigcal {
namespace {

const cv::Size kSize(200, 160);
constexpr int kNumLevels = 4;

const test::WaveTexture& Texture() {
  static const test::WaveTexture texture(4.0, 40.0, 0.15, 7);
  return texture;
}

/// Head on, turned, and both turned and farther away.
std::vector<View> ThreeViews() {
  return {test::LookAtOrigin("a", 1000, 0, 0), test::LookAtOrigin("b", 1000, 0.35, 0),
          test::LookAtOrigin("c", 1250, -0.3, 0.3, 0.2)};
}

const test::PlaneScene& Scene() {
  static const test::PlaneScene scene = test::RenderPlane(Texture(), ThreeViews(), kSize, kNumLevels);
  return scene;
}

MatchOptions OptionsAtLevel(int level, double expected_error_px) {
  MatchOptions options;
  options.level = level;
  options.expected_error_px.assign(3, expected_error_px);
  return options;
}

std::vector<Patch> SomePatches() {
  return test::PatchesOnPlane(3, 6.1, 16);
}

/// The true cameras, of which one view's pictures lie elsewhere by shift_px.
RigCalibration Shifted(RigCalibration calibration, int view, const Eigen::Vector2d& shift_px) {
  Camera camera = calibration.CameraOf(view);
  camera.cx_px += shift_px.x();
  camera.cy_px += shift_px.y();
  calibration.cameras.push_back(camera);
  calibration.views[view].camera = calibration.NumCameras() - 1;
  return calibration;
}

/// Distances between the features of a view and where its track's reference feature is seen in truth.
std::vector<double> ErrorsOf(const TrackSet& set, int view) {
  std::vector<double> errors;
  for (const Track& track : set.tracks) {
    const Observation& reference = track.observations[0];
    for (const Observation& found : track.observations) {
      if (&found == &reference || found.view != view) continue;
      errors.push_back(
          (found.x_px - test::TransferOverPlane(Scene().truth, reference.view, reference.x_px, view)).norm());
    }
  }
  return errors;
}

double Rms(const std::vector<double>& errors) {
  double sum = 0;
  for (const double e : errors) sum += e * e;
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

TrackSet MatchOk(const test::PlaneScene& scene, const RigCalibration& calibration, const std::vector<Patch>& patches,
                 const MatchOptions& options, int num_threads = 1) {
  Execution execution;
  execution.num_threads = num_threads;
  auto tracks = Match(scene.images, calibration, patches, options, execution);
  EXPECT_TRUE(tracks.has_value());
  return *tracks;
}

TEST(Match, FindsFeaturesToAHundredthOfAPixel) {
  const TrackSet set = MatchOk(Scene(), Scene().truth, SomePatches(), OptionsAtLevel(2, 4.0));
  ASSERT_GT(set.tracks.size(), 240u);
  EXPECT_LT(Rms(ErrorsOf(set, 1)), 0.005);
  EXPECT_LT(Rms(ErrorsOf(set, 2)), 0.02);
  for (const Track& track : set.tracks) {
    EXPECT_EQ(track.observations[0].view, 0);  // the view that looks along the normal
    EXPECT_EQ(track.observations[0].ncc, 1);
    EXPECT_EQ(track.source, TrackSource::kPatch);
  }
}

TEST(Match, ConvergesFromSeveralPixelsOff) {
  const RigCalibration off = Shifted(Scene().truth, 1, {-4, 4});
  const TrackSet set = MatchOk(Scene(), off, SomePatches(), OptionsAtLevel(2, 7.0));
  const std::vector<double> errors = ErrorsOf(set, 1);
  EXPECT_GT(errors.size(), 200u);
  const auto good = std::count_if(errors.begin(), errors.end(), [](double e) { return e < 0.05; });
  EXPECT_GT(good, 0.97 * static_cast<double>(errors.size()));
}

TEST(Match, DropsFeaturesThatMovedTooFar) {
  const RigCalibration off = Shifted(Scene().truth, 1, {-4, 4});
  MatchOptions options = OptionsAtLevel(2, 7.0);
  options.expected_error_px[1] = 5.0;  // 5.7 px would be needed
  const TrackSet set = MatchOk(Scene(), off, SomePatches(), options);
  for (const double e : ErrorsOf(set, 1)) EXPECT_GT(e, 0.5);  // whatever is left was found elsewhere, not there
  EXPECT_LT(ErrorsOf(set, 1).size(), 30u);
  EXPECT_GT(ErrorsOf(set, 2).size(), 200u);
}

TEST(Match, DropsFeaturesThatLookDifferent) {
  test::PlaneScene scene = Scene();
  const test::WaveTexture other(4.0, 40.0, 0.15, 99);
  scene.images.views[1] = test::RenderPlane(other, ThreeViews(), kSize, kNumLevels).images.views[1];
  const TrackSet set = MatchOk(scene, scene.truth, SomePatches(), OptionsAtLevel(0, 2.0));
  EXPECT_LT(ErrorsOf(set, 1).size(), 40u);
  for (const Track& track : set.tracks) {
    for (const Observation& o : track.observations) EXPECT_GE(o.ncc, 0.7);
  }
}

TEST(Match, DropsFeaturesOutsideTheSilhouette) {
  test::PlaneScene scene = Scene();
  cv::Mat1b& mask = scene.images.views[1].mask;
  mask.create(kSize);
  mask.setTo(255);
  mask.colRange(0, kSize.width / 2).setTo(0);
  const TrackSet set = MatchOk(scene, scene.truth, SomePatches(), OptionsAtLevel(0, 2.0));
  int in_view = 0;
  for (const Track& track : set.tracks) {
    for (const Observation& o : track.observations) {
      if (o.view != 1) continue;
      ++in_view;
      EXPECT_GE(o.x_px.x(), kSize.width / 2 - 0.5);
    }
  }
  EXPECT_GT(in_view, 80);
}

TEST(Match, DropsFeaturesThatLeaveThePicture) {
  const std::vector<Patch> wide = test::PatchesOnPlane(3, 20.0, 16);  // 300 units wide, pictures are 200
  const TrackSet set = MatchOk(Scene(), Scene().truth, wide, OptionsAtLevel(2, 4.0));
  ASSERT_GT(set.tracks.size(), 10u);
  EXPECT_LT(set.tracks.size(), 100u);
  for (const Track& track : set.tracks) {
    for (const Observation& o : track.observations) EXPECT_TRUE(Scene().images.views[o.view].IsObject(o.x_px));
  }
}

TEST(Match, LeavesOutWhatHasNoTexture) {
  test::PlaneScene scene = Scene();
  for (ViewImages& view : scene.images.views) view.gray = BuildPyramid(cv::Mat1f(kSize, 0.0f), kNumLevels);
  EXPECT_TRUE(MatchOk(scene, scene.truth, SomePatches(), OptionsAtLevel(2, 4.0)).tracks.empty());
}

/// How far off features are (full-size pixels) that were matched at level 2 alone, in the view with another scale.
double ErrorAtLevelTwo(const std::vector<ViewImages>& images) {
  constexpr int kLevel = 2, kSide = 7;
  const auto views = ViewGeometries(Scene().truth);
  std::vector<double> errors;
  for (const Patch& patch : test::PatchesOnPlane(3, 11.0, 7)) {
    const auto frame = FrameOf(patch, views, Scene().images);
    WindowShape wide, shape;
    const bool shaped = ShapeInView(*frame, views[0], kLevel, kSide + 2 * kTextureMargin, wide) &&
                        ShapeInView(*frame, views[2], kLevel, kSide, shape);
    const Eigen::Vector2d from = test::TruePixel(Scene().truth, 0, patch.centre_in_world);
    const Eigen::Vector2d to = test::TruePixel(Scene().truth, 2, patch.centre_in_world);
    const auto reference = SampleReference(images[0].gray[kLevel], wide, from / 4);
    if (!shaped || !reference) continue;
    const auto sought = MakeTemplate(*reference, shape);
    const auto fit = FitWindow(images[2].gray[kLevel], *sought, to / 4, 1.0);
    if (fit) errors.push_back((4 * fit->centre_px - to).norm());
  }
  EXPECT_GT(errors.size(), 30u);
  return Rms(errors);
}

TEST(Match, LevelsShareTheCentreOfTheFirstPixel) {
  EXPECT_LT(ErrorAtLevelTwo(Scene().images.views), 0.2);
  // The other convention (cv::resize: pixel corners stay together) must be noticed: it is off by 1.5 px (1 - 0.8) here.
  std::vector<ViewImages> by_corner = Scene().images.views;
  for (ViewImages& view : by_corner) {
    for (int l = 1; l < kNumLevels; ++l) cv::resize(view.gray[l - 1], view.gray[l], {}, 0.5, 0.5, cv::INTER_AREA);
  }
  EXPECT_GT(ErrorAtLevelTwo(by_corner), 0.3);
}

TEST(Match, ReportsPixelsOfTheOriginalPicture) {
  test::PlaneScene scene = Scene();
  Camera lens = scene.truth.cameras[0];
  lens.k1 = -0.3;
  for (ViewImages& view : scene.images.views) view.undistorted_with = lens;
  const TrackSet plain = MatchOk(Scene(), Scene().truth, SomePatches(), OptionsAtLevel(0, 2.0));
  const TrackSet distorted = MatchOk(scene, scene.truth, SomePatches(), OptionsAtLevel(0, 2.0));
  ASSERT_EQ(plain.tracks.size(), distorted.tracks.size());
  const Observation &a = plain.tracks[0].observations[1], &b = distorted.tracks[0].observations[1];
  EXPECT_GT((a.x_px - b.x_px).norm(), 0.01);
  EXPECT_LT((OriginalFromUndistorted(lens, a.x_px) - b.x_px).norm(), 1e-12);
}

TEST(Match, CovariancesOfATrackAddUpToItsSpread) {
  const auto noisy = test::RenderPlane(Texture(), ThreeViews(), kSize, kNumLevels, 0.02, 3);
  const TrackSet set = MatchOk(noisy, noisy.truth, SomePatches(), OptionsAtLevel(0, 2.0));
  double predicted = 0;
  for (const Track& track : set.tracks) {
    for (const Observation& o : track.observations) {
      // The head-on view and this one have nearly the same scale, so covariances add without being mapped.
      if (o.view == 1) predicted += (o.covariance_px2 + track.observations[0].covariance_px2).trace();
    }
  }
  const std::vector<double> errors = ErrorsOf(set, 1);
  const double actual = Rms(errors);
  predicted = std::sqrt(predicted / static_cast<double>(errors.size()));
  EXPECT_NEAR(predicted / actual, 1.0, 0.3) << predicted << " for " << actual << " px";
}

TEST(Match, SameTracksOnOneAndTwoThreads) {
  const MatchOptions options = OptionsAtLevel(2, 5.0);
  const TrackSet one = MatchOk(Scene(), Scene().truth, SomePatches(), options, 1);
  const TrackSet two = MatchOk(Scene(), Scene().truth, SomePatches(), options, 2);
  ASSERT_EQ(one.tracks.size(), two.tracks.size());
  for (std::size_t i = 0; i < one.tracks.size(); ++i) {
    ASSERT_EQ(one.tracks[i].observations.size(), two.tracks[i].observations.size());
    for (std::size_t k = 0; k < one.tracks[i].observations.size(); ++k) {
      const Observation &a = one.tracks[i].observations[k], &b = two.tracks[i].observations[k];
      EXPECT_EQ(a.view, b.view);
      EXPECT_EQ(a.x_px, b.x_px);
      EXPECT_EQ(a.covariance_px2, b.covariance_px2);
    }
  }
}

TEST(Match, SubsamplesByBlocksDownToTheFloor) {
  const std::vector<Patch> patches = test::PatchesOnPlane(3, 2.0, 40);  // 1600 in an area of 80 x 80 px
  MatchOptions options = OptionsAtLevel(0, 2.0);
  options.kept_share = 0.15;
  options.min_features_per_view = 10;
  const std::size_t by_share = MatchOk(Scene(), Scene().truth, patches, options).tracks.size();
  EXPECT_GT(by_share, 0.12 * 1600);
  EXPECT_LT(by_share, 0.25 * 1600);
  options.min_features_per_view = 700;
  const std::size_t by_floor = MatchOk(Scene(), Scene().truth, patches, options).tracks.size();
  EXPECT_GT(by_floor, 680u);
  EXPECT_LE(by_floor, 900u);
}

TEST(Match, SubsamplingNeedsBlocks) {
  MatchOptions options = OptionsAtLevel(0, 2.0);
  options.kept_share = 0.15;
  options.blocks_per_side = 0;
  EXPECT_THROW((void)Match(Scene().images, Scene().truth, SomePatches(), options, {}), BrokenPromise);
}

TEST(Match, KeepsFewerTracksWhereThereAreTooManyFeatures) {
  const std::vector<Patch> patches = test::PatchesOnPlane(3, 2.0, 40);  // 1600, seen by all views
  MatchOptions options = OptionsAtLevel(0, 2.0);
  const std::size_t all = MatchOk(Scene(), Scene().truth, patches, options).tracks.size();
  EXPECT_GT(all, 1500u);
  options.max_features = 1600 * Scene().truth.NumViews() / 4;
  options.min_features_per_view = 10;
  const std::size_t kept = MatchOk(Scene(), Scene().truth, patches, options).tracks.size();
  EXPECT_GT(kept, all / 5);
  EXPECT_LT(kept, all / 3);
}

TEST(Match, StopsOnRequest) {
  std::stop_source source;
  source.request_stop();
  Execution execution;
  execution.stop = source.get_token();
  const auto tracks = Match(Scene().images, Scene().truth, SomePatches(), OptionsAtLevel(0, 2.0), execution);
  ASSERT_FALSE(tracks.has_value());
  EXPECT_EQ(tracks.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace rigcal
