#include "drivers/sim/sim_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/random.h"
#include "sim_fixtures/view_at.h"

namespace rigcal {
namespace {

constexpr std::uint64_t kNoiseTask = 60000;  ///< DeriveSeed: + camera, then the angle, then the attempt
constexpr double kSameAngle_rad = 1e-9;      ///< of noise
constexpr double kTurn_rad = 2 * std::numbers::pi;

}  // namespace

double SimTable::AngleLocked() const {
  if (faults_.stuck) return from_rad_;
  const double way_rad = to_rad_ - from_rad_;
  const double gone_rad = (clock_.NowS() - begin_s_) * speed_rad_s_;
  return std::abs(way_rad) <= gone_rad ? to_rad_ : from_rad_ + std::copysign(gone_rad, way_rad);
}

void SimTable::Start(double target_rad, double speed_rad_s) {
  const std::lock_guard lock(mutex_);
  from_rad_ = AngleLocked();
  begin_s_ = clock_.NowS();
  to_rad_ = target_rad;
  speed_rad_s_ = speed_rad_s;
}

void SimTable::Halt() {
  const std::lock_guard lock(mutex_);
  from_rad_ = to_rad_ = AngleLocked();
}

double SimTable::Angle() const {
  const std::lock_guard lock(mutex_);
  return AngleLocked();
}

bool SimTable::Moving() const {
  const std::lock_guard lock(mutex_);
  return AngleLocked() != to_rad_;
}

SimTableFaults SimTable::Faults() const {
  const std::lock_guard lock(mutex_);
  return faults_;
}

void SimTable::SetFaults(const SimTableFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

SimRig::SimRig(sim::Studio studio, const sim::ShotOptions& shot, Clock& clock)
    : studio_(std::move(studio)), shot_(shot), clock_(clock), table_(clock), faults_(studio_.truth.cameras.size()) {}

Result<cv::Mat> SimRig::Picture(int camera, double angle_rad, int attempt, int bits, const std::stop_token& stop) {
  const int view = sim::ViewAt(studio_, camera, angle_rad);
  const Execution execution{.stop = stop, .num_threads = 1, .report_progress = {}};
  const Result<sim::RenderedView> rendered = sim::RenderView(studio_, view, shot_.samples_per_side, execution);
  if (!rendered) return Fail(rendered.error());
  sim::SensorOptions sensor = shot_.sensor;
  sensor.bits = bits;
  const auto steps = static_cast<std::uint64_t>(std::llround(std::remainder(angle_rad, kTurn_rad) / kSameAngle_rad));
  std::uint64_t seed = DeriveSeed(studio_.options.random_seed, kNoiseTask + static_cast<std::uint64_t>(camera));
  seed = DeriveSeed(DeriveSeed(seed, steps), static_cast<std::uint64_t>(attempt));
  return sim::Expose(rendered->radiance, sensor, seed);
}

SimCameraFaults SimRig::Faults(int camera) const {
  const std::lock_guard lock(mutex_);
  return faults_.at(camera);
}

void SimRig::SetFaults(int camera, const SimCameraFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_.at(camera) = faults;
}

bool SimRig::Hold(int camera) {
  const std::lock_guard lock(mutex_);
  return held_.insert(camera).second;
}

void SimRig::Free(int camera) {
  const std::lock_guard lock(mutex_);
  held_.erase(camera);
}

}  // namespace rigcal
