#include "sim_fixtures/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "sim_fixtures/surface.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Studio MakeOrDie(const StudioOptions& options) {
  auto studio = MakeStudio(options, {});
  EXPECT_TRUE(studio.has_value()) << studio.error().message;
  return std::move(*studio);
}

StudioOptions Marker() {
  StudioOptions options;
  options.scene = Scene::kMarker;
  options.cell_m = 0.0003;
  options.num_stops = 4;
  options.width_px = 640;
  options.height_px = 480;
  return options;
}

/// Centroid of the picture of a sphere, from the circle where sight lines touch it: exact, also with distortion.
Vector2d CentroidOfSphere(const Camera& camera, const Vector3d& centre_in_cam, double radius_m) {
  const double shrink = 1 - radius_m * radius_m / centre_in_cam.squaredNorm();
  const Vector3d u = centre_in_cam.unitOrthogonal(), v = centre_in_cam.normalized().cross(u);
  constexpr int kCorners = 720;
  std::vector<Vector2d> outline;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    const Vector3d x =
        shrink * centre_in_cam + radius_m * std::sqrt(shrink) * (std::cos(angle) * u + std::sin(angle) * v);
    outline.push_back(*Project(camera, x));
  }
  Vector2d sum = Vector2d::Zero();
  double area = 0;
  for (int i = 0; i < kCorners; ++i) {
    const Vector2d a = outline[i] - outline[0], b = outline[(i + 1) % kCorners] - outline[0];
    const double cross = a.x() * b.y() - a.y() * b.x();
    area += cross;
    sum += cross * (a + b) / 3;
  }
  return outline[0] + sum / area;
}

/// Weighted centroid of an image in pixels, (0,0) = centre of the first pixel.
Vector2d Centroid(const cv::Mat1f& weight) {
  double sum = 0, x = 0, y = 0;
  for (int row = 0; row < weight.rows; ++row) {
    for (int column = 0; column < weight.cols; ++column) {
      const double w = weight(row, column);
      sum += w, x += w * column, y += w * row;
    }
  }
  return Vector2d(x, y) / sum;
}

void ExpectMarkerWhereProjected(const StudioOptions& options) {
  const Studio studio = MakeOrDie(options);
  for (int view = 0; view < studio.truth.NumViews(); ++view) {
    const auto rendered = RenderView(studio, view, 4, {});
    ASSERT_TRUE(rendered.has_value());
    const Vector3d centre_in_cam = studio.truth.views[view].cam_from_world * kMarkerCentreInWorld_m;
    const Vector2d expected_px = CentroidOfSphere(studio.truth.CameraOf(view), centre_in_cam, kMarkerRadius_m);
    EXPECT_LT((Centroid(rendered->coverage) - expected_px).norm(), 0.02) << "view " << view;
  }
}

// A picture whose origin were the pixel's corner would be off by 0.7 px here.
TEST(RenderView, MarkerLiesWhereProjectSays) {
  ExpectMarkerWhereProjected(Marker());
}

TEST(RenderView, MarkerLiesWhereProjectSaysWithDistortion) {
  StudioOptions options = Marker();
  options.distortion = {-0.2, 0.1, 0.002, -0.001, 0.0};
  ExpectMarkerWhereProjected(options);
}

/// From the middle of the marker's picture towards its light side.
Vector2d TowardsLight_px(const Studio& studio, int view) {
  const auto rendered = RenderView(studio, view, 4, {});
  cv::Mat1f light;
  cv::multiply(rendered->radiance, rendered->coverage, light);
  return Centroid(light) - Centroid(rendered->coverage);
}

// Were the lamps fixed to the table, half a turn would bring the light to the other side.
TEST(RenderView, ShadingStaysInTheStudioWhileTheTableTurns) {
  const Studio studio = MakeOrDie(Marker());
  const Vector2d before = TowardsLight_px(studio, 0), after = TowardsLight_px(studio, 2);
  EXPECT_GT(before.norm(), 1.0);
  EXPECT_LT((after - before).norm(), 0.25 * before.norm());
}

TEST(RenderView, GantrySeesOneShadingFromEverywhere) {
  StudioOptions options = Marker();
  options.motion = Motion::kGantry;
  options.num_views = 12;
  const Studio studio = MakeOrDie(options);
  const Vector3d top = kMarkerCentreInWorld_m + Vector3d(0, 0, kMarkerRadius_m);
  std::vector<float> seen;
  for (int view = 6; view < 12; ++view) {  // the high ones
    const auto rendered = RenderView(studio, view, 2, {});
    const auto x_px = Project(studio.truth.CameraOf(view), studio.truth.views[view].cam_from_world * top);
    seen.push_back(
        rendered->radiance(static_cast<int>(std::lround(x_px->y())), static_cast<int>(std::lround(x_px->x()))));
  }
  for (const float value : seen) EXPECT_NEAR(value, seen[0], 0.02f * seen[0]);
}

// The same place has the same reflectance in two views of a turning object; differences are shading alone.
TEST(RenderView, TextureTurnsWithTheObject) {
  StudioOptions options;
  options.scene = Scene::kTextured;
  options.cell_m = 0.002;
  options.num_stops = 24;
  options.width_px = 480;
  options.height_px = 360;
  const Studio studio = MakeOrDie(options);
  const auto first = RenderView(studio, 0, 3, {}), second = RenderView(studio, 1, 3, {});
  double sum_a = 0, sum_b = 0, sum_aa = 0, sum_bb = 0, sum_ab = 0;
  int count = 0;
  for (const VisiblePoint& point : SurfacePoints(studio, 1500, 2)) {
    if (point.views.size() < 2 || point.views[0] != 0 || point.views[1] != 1) continue;
    const auto value = [&](const RenderedView& rendered, int view) {
      const auto x_px =
          Project(studio.truth.CameraOf(view), studio.truth.views[view].cam_from_world * point.x_in_world);
      cv::Mat1f sampled;
      cv::getRectSubPix(rendered.radiance, {1, 1}, {static_cast<float>(x_px->x()), static_cast<float>(x_px->y())},
                        sampled);
      return static_cast<double>(sampled(0, 0));
    };
    const double a = value(*first, 0), b = value(*second, 1);
    sum_a += a, sum_b += b, sum_aa += a * a, sum_bb += b * b, sum_ab += a * b;
    ++count;
  }
  ASSERT_GT(count, 100);
  const double covariance = sum_ab / count - sum_a / count * sum_b / count;
  const double sigma_a = std::sqrt(sum_aa / count - sum_a / count * sum_a / count);
  const double sigma_b = std::sqrt(sum_bb / count - sum_b / count * sum_b / count);
  EXPECT_GT(covariance / (sigma_a * sigma_b), 0.9);
}

TEST(RenderView, SameBytesForOneAndTwoThreads) {
  StudioOptions options;
  options.surroundings = Surroundings::kBackdrop;
  options.cell_m = 0.002;
  options.num_stops = 3;
  options.width_px = 320;
  options.height_px = 240;
  const Execution one{.stop = {}, .num_threads = 1, .report_progress = {}};
  const Execution two{.stop = {}, .num_threads = 2, .report_progress = {}};
  const Studio alone = MakeOrDie(options);
  const auto together = MakeStudio(options, two);
  const auto a = RenderView(alone, 1, 3, one), b = RenderView(*together, 1, 3, two);
  EXPECT_EQ(cv::norm(a->radiance, b->radiance, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(a->coverage, b->coverage, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(Expose(a->radiance, {}, 7), Expose(b->radiance, {}, 7), cv::NORM_INF), 0);
}

TEST(RenderView, StopsOnRequest) {
  const Studio studio = MakeOrDie(Marker());
  std::stop_source source;
  source.request_stop();
  const auto rendered = RenderView(studio, 0, 1, {.stop = source.get_token(), .num_threads = 1, .report_progress = {}});
  ASSERT_FALSE(rendered.has_value());
  EXPECT_EQ(rendered.error().code, ErrorCode::kCancelled);
}

TEST(Expose, NoiseHasItsSigmaAndItsSeed) {
  const cv::Mat1f flat(200, 300, 0.2f);
  SensorOptions sensor{.blur_sigma_px = 0, .noise_sigma = 2.0, .linear = true, .bits = 16};
  const cv::Mat picture = Expose(flat, sensor, 5);
  cv::Scalar mean, sigma;
  cv::meanStdDev(picture, mean, sigma);
  EXPECT_NEAR(mean[0], 0.2 * 65535, 0.02 * 257);
  EXPECT_NEAR(sigma[0] / 257, 2.0, 0.02);
  EXPECT_EQ(cv::norm(picture, Expose(flat, sensor, 5), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(picture, Expose(flat, sensor, 6), cv::NORM_INF), 0);
}

TEST(Expose, FollowsTheSrgbCurve) {
  const SensorOptions sensor{.blur_sigma_px = 0, .noise_sigma = 0, .linear = false, .bits = 8};
  // IEC 61966-2-1: 18 % grey is 117.6 of 255, 0.001 is 3.3.
  EXPECT_EQ(Expose(cv::Mat1f(4, 4, 0.18f), sensor, 0).at<std::uint8_t>(1, 1), 118);
  EXPECT_EQ(Expose(cv::Mat1f(4, 4, 0.001f), sensor, 0).at<std::uint8_t>(1, 1), 3);
  EXPECT_EQ(Expose(cv::Mat1f(4, 4, 2.0f), sensor, 0).at<std::uint8_t>(1, 1), 255);
}

}  // namespace
}  // namespace rigcal::sim
