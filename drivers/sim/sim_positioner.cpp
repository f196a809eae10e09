#include "drivers/sim/sim_positioner.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace rigcal {
namespace {

constexpr double kPoll_s = 0.05;                              ///< how often the table is asked where it stands
constexpr double kSpeed_rad_s = 30 * std::numbers::pi / 180;  ///< where the rig file has none: a common turntable's

}  // namespace

Result<std::unique_ptr<PositionerDevice>> SimPositioner::Open(std::shared_ptr<SimRig> rig,
                                                              const PositionerSettings& settings) {
  if (settings.axes.size() != 1 || settings.axes.front().unit != AxisUnit::kRadian) {
    return Fail(ErrorCode::kUnsupported, "sim: the simulated positioner is a turntable with one axis, not {} axes",
                settings.axes.size());
  }
  return std::unique_ptr<PositionerDevice>(new SimPositioner(std::move(rig), settings));
}

SimPositioner::SimPositioner(std::shared_ptr<SimRig> rig, PositionerSettings settings)
    : rig_(std::move(rig)), settings_(std::move(settings)) {
  const double speed_rad_s = settings_.axes.front().speed;
  speed_rad_s_ = speed_rad_s > 0 ? speed_rad_s : kSpeed_rad_s;
}

Result<void> SimPositioner::Home(const std::stop_token& stop) {
  if (rig_->Table().Faults().no_home) {
    return Fail(ErrorCode::kDevice, "sim: axis '{}' does not find its zero", settings_.axes.front().name);
  }
  return Turn(0, stop);
}

Result<RecordedStop> SimPositioner::MoveTo(const StopTarget& target, const std::stop_token& stop) {
  if (Result<void> valid = CheckTarget(target, settings_.axes, "sim"); !valid) return Fail(valid.error());
  const AxisSettings& axis = settings_.axes.front();
  const double target_rad = target.axes.front();
  const bool from_its_side = axis.approach == 0 || (target_rad - rig_->Table().Angle()) * axis.approach > 0;
  if (!from_its_side && axis.backlash > 0) {
    if (Result<void> turned = Turn(target_rad - axis.approach * axis.backlash, stop); !turned) {
      return Fail(turned.error());
    }
  }
  if (Result<void> turned = Turn(target_rad, stop); !turned) return Fail(turned.error());
  const double reported_rad = rig_->Table().Angle();
  if (std::abs(reported_rad - target_rad) > settings_.position_tolerance_rad) {
    return Fail(ErrorCode::kDevice, "sim: axis '{}' was sent to {:.6f} rad and stands at {:.6f}, {:.6f} are allowed",
                axis.name, target_rad, reported_rad, settings_.position_tolerance_rad);
  }
  return RecordedStop{
      .id = target.id,
      .axes = {{.axis = axis.name, .unit = AxisUnit::kRadian, .commanded = target_rad, .reported = reported_rad}}};
}

Result<void> SimPositioner::Turn(double target_rad, const std::stop_token& stop) {
  struct HaltUnlessThere {
    SimTable& table;
    ~HaltUnlessThere() { table.Halt(); }  // at its target the table rests already
  } const halt{rig_->Table()};
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "sim: the move was stopped on request");
  rig_->Table().Start(target_rad + rig_->Table().Faults().miss_rad, speed_rad_s_);
  return WaitForEnd(target_rad, stop);
}

Result<void> SimPositioner::WaitForEnd(double target_rad, const std::stop_token& stop) {
  const std::string& axis = settings_.axes.front().name;
  const double end_s = rig_->Time().NowS() + settings_.move_timeout_s;
  while (rig_->Table().Moving()) {
    if (!rig_->Time().Wait(kPoll_s, stop)) return Fail(ErrorCode::kCancelled, "sim: the move was stopped on request");
    const SimTableFaults faults = rig_->Table().Faults();
    if (faults.alarm) return Fail(ErrorCode::kDevice, "sim: axis '{}' raised an alarm", axis);
    if (faults.gone) return Fail(ErrorCode::kDevice, "sim: the connection to axis '{}' is lost", axis);
    if (rig_->Time().NowS() > end_s) {
      return Fail(ErrorCode::kTimeout, "sim: axis '{}' did not reach {:.6f} rad within {:.1f} s", axis, target_rad,
                  settings_.move_timeout_s);
    }
  }
  return {};
}

Result<void> SimPositioner::FinishStop(const Result<void>& /*taken*/) {
  return {};
}

void SimPositioner::Halt() noexcept {
  rig_->Table().Halt();
}

}  // namespace rigcal
