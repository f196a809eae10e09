#include <benchmark/benchmark.h>

#include "core/adjust/adjust.h"
#include "tests/adjust/synthetic_scene.h"

// How the cost of the adjustment grows with views and tracks, from cameras that are 6 pixels off, with and without the
// covariance. items_per_second counts observations, CPU seconds.

namespace rigcal {
namespace {

void AdjustHemisphere(benchmark::State& state) {
  constexpr double kStartErrorPx = 6;
  synthetic::Scene scene =
      synthetic::MakeScene(synthetic::Hemisphere(static_cast<int>(state.range(0))), kStartErrorPx,
                           {.sigma_px = 0.3, .outlier_share = 0.05}, 1, static_cast<int>(state.range(1)));
  scene.options.estimate_covariance = state.range(2) != 0;
  int num_observations = 0, num_iterations = 0;
  for (auto _ : state) {
    const Result<Adjustment> adjusted = scene.Run();
    if (!adjusted) {
      state.SkipWithError(adjusted.error().message.c_str());
      break;
    }
    num_observations = adjusted->report.num_observations;
    num_iterations = adjusted->report.num_iterations;
  }
  state.SetItemsProcessed(state.iterations() * num_observations);
  state.counters["observations"] = num_observations;
  state.counters["iterations"] = num_iterations;
}
BENCHMARK(AdjustHemisphere)
    ->ArgNames({"views", "points", "covariance"})
    ->Args({8, 2000, 1})
    ->Args({16, 2000, 1})
    ->Args({32, 2000, 1})
    ->Args({64, 2000, 1})
    ->Args({16, 500, 1})
    ->Args({16, 8000, 1})
    ->Args({16, 2000, 0})
    ->Args({64, 2000, 0})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace rigcal
