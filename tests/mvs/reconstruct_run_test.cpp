#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <stop_token>

#include "core/mvs/reconstruct.h"
#include "tests/mvs/surface_error.h"

namespace rigcal {
namespace {

using test::kDegree;

constexpr int kSidePx = 90;

/// The plane z = 0, textured everywhere.
const test::SurfaceScene& PlaneScene() {
  static const test::SurfaceScene scene =
      test::RenderSurface(test::PlaneAtHeight(0), test::SolidTexture(8, 30, 0.12, 13),
                          test::ViewsAboutZ(7, 25 * kDegree), {kSidePx, kSidePx}, 1);
  return scene;
}

TEST(Reconstruct, DoesNotDependOnTheThreads) {
  const test::SurfaceScene& ball = test::BallScene();
  const StereoOptions options{.level = test::kBallLevel};
  const auto one = Reconstruct(ball.images, ball.truth, options, {.num_threads = 1});
  const auto two = Reconstruct(ball.images, ball.truth, options, {.num_threads = 2});
  ASSERT_TRUE(one && two);
  ASSERT_FALSE(one->empty());
  ASSERT_EQ(one->size(), two->size());
  for (std::size_t i = 0; i < one->size(); ++i) {
    const Patch &a = (*one)[i], &b = (*two)[i];
    ASSERT_EQ(a.centre_in_world, b.centre_in_world) << "patch " << i;
    ASSERT_EQ(a.normal_in_world, b.normal_in_world) << "patch " << i;
    ASSERT_EQ(a.reference_view, b.reference_view) << "patch " << i;
    ASSERT_EQ(a.visible_views, b.visible_views) << "patch " << i;
    ASSERT_EQ(a.ncc, b.ncc) << "patch " << i;
  }
}

TEST(Reconstruct, StopsWhenToldTo) {
  const test::SurfaceScene& plane = PlaneScene();
  for (const double stop_at : {0.0, 0.3, 0.6}) {
    std::stop_source source;
    if (stop_at == 0) source.request_stop();
    Execution execution{.stop = source.get_token(), .report_progress = [&](double share) {
                          if (share >= stop_at) source.request_stop();
                        }};
    const auto patches = Reconstruct(plane.images, plane.truth, {.level = 0}, execution);
    ASSERT_FALSE(patches) << stop_at;
    EXPECT_EQ(patches.error().code, ErrorCode::kCancelled) << stop_at;
  }
}

TEST(Reconstruct, ReportsRisingProgressUpToOne) {
  const test::SurfaceScene& plane = PlaneScene();
  std::vector<double> shares;
  const Execution execution{.report_progress = [&](double share) { shares.push_back(share); }};
  ASSERT_TRUE(Reconstruct(plane.images, plane.truth, {.level = 0}, execution));
  ASSERT_FALSE(shares.empty());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_NEAR(shares.back(), 1, 1e-9);
}

TEST(Reconstruct, FindsNothingOffTheMask) {
  ImageSet images = PlaneScene().images;
  const RigCalibration& truth = PlaneScene().truth;
  constexpr double kRadius = 28;  // of the disc of the plane that counts as the object
  for (int view = 0; view < truth.NumViews(); ++view) {
    images.views[view].mask = cv::Mat1b(kSidePx, kSidePx, std::uint8_t{0});
    std::vector<cv::Point> outline;
    for (int i = 0; i < 360; ++i) {
      const Eigen::Vector2d x_px =
          test::TrueImage(truth, view, kRadius * Eigen::Vector3d(std::cos(i * kDegree), std::sin(i * kDegree), 0));
      outline.emplace_back(cvRound(x_px.x()), cvRound(x_px.y()));
    }
    cv::fillPoly(images.views[view].mask, std::vector{outline}, cv::Scalar(255));
  }
  const auto patches = Reconstruct(images, truth, {.level = 0}, {});
  ASSERT_TRUE(patches) << patches.error().message;
  double farthest = 0;
  for (const Patch& patch : *patches) farthest = std::max(farthest, patch.centre_in_world.head<2>().norm());
  RecordProperty("farthest", std::to_string(farthest));
  RecordProperty("patches", static_cast<int>(patches->size()));
  EXPECT_LT(farthest, kRadius + 1);  // the outline is drawn to the pixel
  EXPECT_GT(farthest, kRadius - 3) << "the object's rim is missing";
  constexpr double kCells = std::numbers::pi * kRadius * kRadius / 4;
  EXPECT_GT(static_cast<double>(patches->size()), 0.8 * kCells);
}

TEST(Reconstruct, RespectsTheLeastNumberOfViews) {
  const test::SurfaceScene& plane = PlaneScene();
  for (const int min_views : {3, 6}) {
    const auto patches = Reconstruct(plane.images, plane.truth, {.level = 0, .min_views = min_views}, {});
    ASSERT_TRUE(patches) << patches.error().message;
    EXPECT_FALSE(patches->empty());
    int fewest = plane.truth.NumViews();
    for (const Patch& patch : *patches) fewest = std::min(fewest, static_cast<int>(patch.visible_views.size()));
    EXPECT_GE(fewest, min_views);
    if (min_views == 3) {
      EXPECT_LT(fewest, 6) << "nothing was tested";
    }
  }
  const auto too_many = Reconstruct(plane.images, plane.truth, {.level = 0, .min_views = 8}, {});
  ASSERT_TRUE(too_many);
  EXPECT_TRUE(too_many->empty()) << "there are seven views";
}

}  // namespace
}  // namespace rigcal
