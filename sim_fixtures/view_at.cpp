#include "sim_fixtures/view_at.h"

#include <cmath>
#include <numbers>

#include "core/base/ensure.h"
#include "core/base/random.h"
#include "sim_fixtures/stop_error.h"

namespace rigcal::sim {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;
constexpr double kSameAngle_rad = 1e-9;
constexpr std::uint64_t kAddedStopTask = 7;  ///< DeriveSeed, then the angle in kSameAngle_rad

double DistanceOf(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, kTurn_rad));
}

StopError DrawStopError(const StudioOptions& options, double angle_rad) {
  constexpr double kRadPerDeg = std::numbers::pi / 180, kMetrePerMm = 1e-3;
  const auto steps = static_cast<std::uint64_t>(std::llround(angle_rad / kSameAngle_rad));
  Random random(DeriveSeed(DeriveSeed(options.random_seed, kAddedStopTask), steps));
  StopError error = StopError::Zero();
  error[kStep] = options.step_error_deg * kRadPerDeg * random.Normal();
  for (const int k : {kWobbleX, kWobbleY}) error[k] = options.wobble_deg * kRadPerDeg * random.Normal();
  for (const int k : {kRunOutX, kRunOutY}) error[k] = options.run_out_mm * kMetrePerMm * random.Normal();
  return error;
}

}  // namespace

int ViewAt(Studio& studio, int camera, double commanded_rad) {
  Ensure(studio.options.motion == Motion::kTurntable, "only a turntable has angles");
  for (int v = 0; v < studio.truth.NumViews(); ++v) {
    const int stop = studio.stop[v];
    if (studio.truth.views[v].camera == camera &&
        DistanceOf(studio.commanded_rad[stop], commanded_rad) <= kSameAngle_rad) {
      return v;
    }
  }
  int stop = 0;
  const int num_stops = static_cast<int>(studio.commanded_rad.size());
  while (stop < num_stops && DistanceOf(studio.commanded_rad[stop], commanded_rad) > kSameAngle_rad) ++stop;
  if (stop == num_stops) {
    studio.commanded_rad.push_back(commanded_rad);
    studio.stop_errors.push_back(DrawStopError(studio.options, std::remainder(commanded_rad, kTurn_rad)));
  }
  const StopError& error = studio.stop_errors[stop];
  const Rigid3d stage_from_world = StageFromWorld(studio.commanded_rad[stop], error);
  studio.truth.views.push_back(
      {fmt::format("cam{}_stop{}.png", camera, stop), camera, studio.cam_from_stage.at(camera) * stage_from_world});
  studio.stage_from_world.push_back(stage_from_world);
  studio.table_angle_rad.push_back(studio.commanded_rad[stop] + error[kStep]);
  studio.stop.push_back(stop);
  return studio.truth.NumViews() - 1;
}

}  // namespace rigcal::sim
