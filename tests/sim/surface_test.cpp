#include "sim_fixtures/surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim_fixtures/disturb.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;

class SurfaceTest : public testing::Test {
 protected:
  static Studio Make() {
    StudioOptions options;
    options.scene = Scene::kThin;
    options.cell_m = 0.0012;
    options.num_cameras = 2;
    options.num_stops = 9;
    options.width_px = 640;
    options.height_px = 480;
    options.distortion = {-0.1, 0, 0.001, 0, 0};
    auto studio = MakeStudio(options, {});
    EXPECT_TRUE(studio.has_value());
    return std::move(*studio);
  }
  static const Studio& Shared() {
    static const Studio studio = Make();
    return studio;
  }
  const Studio& studio_ = Shared();
  std::vector<VisiblePoint> points_ = SurfacePoints(studio_, 800, 2);
};

TEST_F(SurfaceTest, EveryListedViewSeesThePoint) {
  ASSERT_EQ(points_.size(), 800U);
  for (const VisiblePoint& point : points_) {
    for (const int view : point.views) {
      const auto x_px =
          Project(studio_.truth.CameraOf(view), studio_.truth.views[view].cam_from_world * point.x_in_world);
      ASSERT_TRUE(x_px.has_value());
      const auto hit = SurfaceAt(studio_, view, *x_px);
      ASSERT_TRUE(hit.has_value());
      EXPECT_LT((hit->x_in_world - point.x_in_world).norm(), 3e-5);
    }
  }
}

TEST_F(SurfaceTest, NoOtherViewSeesThePoint) {
  int occluded = 0, unexplained = 0;
  for (const VisiblePoint& point : points_) {
    for (int view = 0; view < studio_.truth.NumViews(); ++view) {
      if (std::find(point.views.begin(), point.views.end(), view) != point.views.end()) continue;
      const Rigid3d& cam_from_world = studio_.truth.views[view].cam_from_world;
      const Vector3d towards = (CentreInWorld(cam_from_world) - point.x_in_world).normalized();
      // The facet may lean a few degrees away from the smooth normal, at a crease more.
      const double safely_seen = std::cos((kSteepestView_deg - 15) * std::numbers::pi / 180);
      if (towards.dot(point.normal_in_world) < safely_seen) continue;
      const auto hit =
          SurfaceAt(studio_, view, *Project(studio_.truth.CameraOf(view), cam_from_world * point.x_in_world));
      ASSERT_TRUE(hit.has_value());
      const double nearer_m = (cam_from_world * point.x_in_world).z() - (cam_from_world * hit->x_in_world).z();
      ++(nearer_m > 1e-5 ? occluded : unexplained);
    }
  }
  EXPECT_GT(occluded, 500);
  EXPECT_LT(unexplained, 0.01 * occluded);
}

TEST_F(SurfaceTest, DistancesAreThoseOfThePicture) {
  constexpr double kOff_m = 0.0002;
  std::vector<Vector3d> on, off;
  for (const VisiblePoint& point : points_) {
    on.push_back(point.x_in_world);
    off.push_back(point.x_in_world + kOff_m * point.normal_in_world);
  }
  const auto on_px = DistancesToSurface_px(studio_, on, {});
  const Execution two{.stop = {}, .num_threads = 2, .report_progress = {}};
  const auto off_px = DistancesToSurface_px(studio_, off, two);
  std::vector<double> ratio;
  for (std::size_t i = 0; i < on.size(); ++i) {
    EXPECT_LT(on_px[i], 1e-3);
    const Rigid3d& cam_from_world = studio_.truth.views[0].cam_from_world;
    ratio.push_back(off_px[i] / (kOff_m * studio_.truth.cameras[0].fx_px / (cam_from_world * on[i]).z()));
  }
  std::sort(ratio.begin(), ratio.end());
  EXPECT_NEAR(ratio[ratio.size() / 2], 1, 0.15);
}

TEST_F(SurfaceTest, DisturbedStartIsOffByExactlyTheTarget) {
  for (const bool shared : {true, false}) {
    for (const double target_px : {6.0, 12.0}) {
      const RigCalibration start =
          Disturb(studio_.truth, points_, {.mean_px = target_px, .shared_intrinsics = shared, .random_seed = 4});
      EXPECT_NEAR(MeanDisplacement_px(studio_.truth, start, points_), target_px, 1e-9);
      EXPECT_EQ(start.NumCameras(), shared ? 2 : studio_.truth.NumViews());
      for (int view = 0; view < start.NumViews(); ++view) {
        EXPECT_NEAR(start.CameraOf(view).fx_px / start.CameraOf(view).fy_px, 1, 1e-12);
        EXPECT_NE(start.CameraOf(view).fx_px, studio_.truth.CameraOf(view).fx_px);
      }
    }
  }
}

TEST_F(SurfaceTest, DisturbanceComesFromTheSeed) {
  const auto first = Disturb(studio_.truth, points_, {.mean_px = 6, .shared_intrinsics = true, .random_seed = 4});
  const auto again = Disturb(studio_.truth, points_, {.mean_px = 6, .shared_intrinsics = true, .random_seed = 4});
  const auto other = Disturb(studio_.truth, points_, {.mean_px = 6, .shared_intrinsics = true, .random_seed = 5});
  EXPECT_EQ(MeanDisplacement_px(first, again, points_), 0);
  EXPECT_GT(MeanDisplacement_px(first, other, points_), 3);
}

}  // namespace
}  // namespace rigcal::sim
