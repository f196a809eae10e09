#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "core/base/random.h"
#include "core/match/match.h"
#include "core/match/match_sparse.h"

// How the cost of matching grows with views and pixels, on a textured plane seen from all sides of its normal.
// items_per_second counts features (a patch's view), CPU seconds.

namespace rigcal {
namespace {

constexpr double kDistance = 1000;  // of the cameras from the plane; one unit is about one pixel

struct Plane {
  RigCalibration calibration;
  ImageSet images;
  std::vector<Patch> patches;
};

/// Waves with a few periods: what they look like does not matter here, only that there is texture everywhere.
float Texture(double x, double y) {
  return static_cast<float>(0.5 + 0.1 * std::sin(x / 1.1) * std::cos(y / 1.3) + 0.1 * std::sin((x + 2 * y) / 2.7) +
                            0.1 * std::cos((2 * x - y) / 5.1));
}

Plane MakePlane(int num_views, int side_px, int num_patches) {
  Plane plane;
  Camera camera;
  camera.id = camera.physical_id = "camera";
  camera.width_px = camera.height_px = side_px;
  camera.fx_px = camera.fy_px = kDistance;
  camera.cx_px = camera.cy_px = (side_px - 1) / 2.0;
  plane.calibration.cameras = {camera};
  std::vector<int> all;
  for (int v = 0; v < num_views; ++v) {
    const double turn = 0.8 * v / num_views - 0.4;  // rad, about the plane's y axis
    Rigid3d pose;
    pose.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY());
    pose.translation = {0, 0, kDistance};
    plane.calibration.views.push_back({std::to_string(v), 0, pose});
    all.push_back(v);
    const Rigid3d world_from_cam = pose.Inverse();
    cv::Mat1f image(side_px, side_px);
    for (int y = 0; y < side_px; ++y) {
      for (int x = 0; x < side_px; ++x) {
        const Eigen::Vector3d ray = world_from_cam.rotation * *RayInCam(camera, {x, y});
        const Eigen::Vector3d p = world_from_cam.translation - ray * (world_from_cam.translation.z() / ray.z());
        image(y, x) = Texture(p.x(), p.y());
      }
    }
    constexpr int kNumLevels = 4;
    ViewImages view;
    view.gray = BuildPyramid(image, kNumLevels);
    view.undistorted_with = camera;
    plane.images.views.push_back(view);
  }
  Random random(1);
  for (int i = 0; i < num_patches; ++i) {
    const double reach = 0.35 * side_px;
    plane.patches.push_back(
        {{random.Uniform(-reach, reach), random.Uniform(-reach, reach), 0}, {0, 0, -1}, 0, all, 1.f});
  }
  return plane;
}

void MatchPatches(benchmark::State& state) {
  const int num_views = static_cast<int>(state.range(0)), side_px = static_cast<int>(state.range(1));
  constexpr int kNumPatches = 2000;
  const Plane plane = MakePlane(num_views, side_px, kNumPatches);
  MatchOptions options;
  options.level = static_cast<int>(state.range(2));
  options.expected_error_px.assign(static_cast<std::size_t>(num_views), static_cast<double>(state.range(3)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(Match(plane.images, plane.calibration, plane.patches, options, {}));
  }
  state.SetItemsProcessed(state.iterations() * kNumPatches * num_views);
}
BENCHMARK(MatchPatches)
    ->ArgNames({"views", "side_px", "level", "expected_error_px"})
    ->Args({4, 512, 2, 7})
    ->Args({8, 512, 2, 7})
    ->Args({16, 512, 2, 7})
    ->Args({8, 256, 2, 7})
    ->Args({8, 1024, 2, 7})
    ->Args({8, 512, 3, 13})
    ->Args({8, 512, 2, 2})
    ->Args({8, 512, 0, 1})
    ->Unit(benchmark::kMillisecond);

void MatchSparseTracks(benchmark::State& state) {
  const int num_views = static_cast<int>(state.range(0)), side_px = static_cast<int>(state.range(1));
  const Plane plane = MakePlane(num_views, side_px, 0);
  SparseMatchOptions options;
  options.expected_error_px.assign(static_cast<std::size_t>(num_views), 7.0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(MatchSparse(plane.images, plane.calibration, options, {}));
  }
  state.SetItemsProcessed(state.iterations() * num_views);
}
BENCHMARK(MatchSparseTracks)
    ->ArgNames({"views", "side_px"})
    ->Args({4, 512})
    ->Args({8, 512})
    ->Args({4, 1024})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rigcal
