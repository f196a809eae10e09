#include <benchmark/benchmark.h>

#include "core/mvs/reconstruct.h"
#include "tests/support/synthetic_surface.h"

// How the cost of the stereo grows with views and pixels, on a textured ball seen from all around. items_per_second
// counts patches, CPU seconds of one thread; "patches" is how many there are.

namespace rigcal {
namespace {

constexpr double kElevationRad = 0.15;
constexpr int kNumLevels = 3;

/// Args: views, side of the pictures, level, expected error of the cameras (full-size pixels; they are exact, whatever
/// it says).
void ReconstructBall(benchmark::State& state) {
  const int num_views = static_cast<int>(state.range(0)), side_px = static_cast<int>(state.range(1));
  StereoOptions options{.level = static_cast<int>(state.range(2))};
  // Waves of 5 pixels of the level and more, so that all levels find the same kind of texture.
  const double finest_px = 5 << options.level;
  const test::SurfaceScene ball =
      test::RenderSurface(test::SphereAtOrigin(0.4 * side_px), test::SolidTexture(finest_px, 4 * finest_px, 0.12, 1),
                          test::ViewsAround(num_views, kElevationRad), {side_px, side_px}, kNumLevels);
  if (state.range(3) > 0) {
    options.expected_error_px.assign(static_cast<std::size_t>(num_views), static_cast<double>(state.range(3)));
  }
  std::size_t num_patches = 0;
  for (auto _ : state) {
    const Result<std::vector<Patch>> patches = Reconstruct(ball.images, ball.truth, options, {});
    num_patches = patches ? patches->size() : 0;
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(num_patches));
  state.counters["patches"] = static_cast<double>(num_patches);
}
BENCHMARK(ReconstructBall)
    ->ArgNames({"views", "side_px", "level", "expected_error_px"})
    ->Args({12, 256, 1, 0})
    ->Args({24, 256, 1, 0})
    ->Args({36, 256, 1, 0})
    ->Args({24, 128, 1, 0})
    ->Args({24, 512, 1, 0})
    ->Args({24, 256, 0, 0})
    ->Args({24, 512, 2, 0})
    ->Args({12, 256, 1, 2})
    ->Args({24, 256, 1, 2})
    ->Args({24, 256, 1, 6})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rigcal
