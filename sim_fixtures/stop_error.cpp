#include "sim_fixtures/stop_error.h"

#include <numbers>

#include "core/base/random.h"

namespace rigcal::sim {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180, kMetrePerMm = 1e-3;
constexpr std::uint64_t kStepTask = 1, kWobbleTask = 3, kRunOutTask = 4;  ///< DeriveSeed

Rigid3d AboutZ(double angle_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ())), Eigen::Vector3d::Zero()};
}

}  // namespace

std::vector<StopError> DrawStopErrors(const StudioOptions& options) {
  Random step(DeriveSeed(options.random_seed, kStepTask));
  Random wobble(DeriveSeed(options.random_seed, kWobbleTask));
  Random run_out(DeriveSeed(options.random_seed, kRunOutTask));
  std::vector<StopError> errors(options.num_stops, StopError::Zero());
  for (int stop = 0; stop < options.num_stops; ++stop) {
    StopError& error = errors[stop];
    for (const int k : {kWobbleX, kWobbleY}) error[k] = options.wobble_deg * kRadPerDeg * wobble.Normal();
    for (const int k : {kRunOutX, kRunOutY}) error[k] = options.run_out_mm * kMetrePerMm * run_out.Normal();
    error[kStep] = stop == 0 ? 0.0 : options.step_error_deg * kRadPerDeg * step.Normal();
  }
  for (const Fault& slip : options.slips) errors[slip.index][kStep] += slip.angle_deg * kRadPerDeg;
  return errors;
}

Rigid3d StageFromWorld(double commanded_rad, const StopError& error) {
  StopError besides_step = error;
  besides_step[kStep] = 0;
  // About one axis angles add: to the last bit what sets were made with before tables wobbled.
  if (besides_step.isZero(0)) return AboutZ(commanded_rad + error[kStep]);
  const Rigid3d small{ExpRotation(error.head<3>()), error.tail<3>()};
  return small * AboutZ(commanded_rad);
}

}  // namespace rigcal::sim
