#include "drivers/driver.h"

#include <cmath>
#include <limits>

namespace rigcal {
namespace {

/// Radians or metres, far below what a machine resolves: a stop at its limit in degrees may be beyond it by rounding.
constexpr double kRounding = 1e-9;

}  // namespace

double ToleranceOf(const PositionerSettings& settings, const AxisSettings& axis) {
  return axis.unit == AxisUnit::kRadian ? settings.position_tolerance_rad : settings.position_tolerance_m;
}

Result<void> CheckTarget(const StopTarget& target, const std::vector<AxisSettings>& axes, const std::string& device) {
  if (target.axes.size() != axes.size()) {
    return Fail(ErrorCode::kBadInput, "{}: stop '{}' has {} values, the machine has {} axes", device, target.id,
                target.axes.size(), axes.size());
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const char* unit = axes[i].unit == AxisUnit::kRadian ? "rad" : "m";
    const double value = target.axes[i];
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const double least = axes[i].least.value_or(-kNone), most = axes[i].most.value_or(kNone);
    if (!std::isfinite(value) || value < least - kRounding || value > most + kRounding) {
      return Fail(ErrorCode::kBadInput, "{}: stop '{}': axis '{}' is to go to {} {}, its limits are {} .. {}", device,
                  target.id, axes[i].name, value, unit, least, most);
    }
  }
  return {};
}

StopTarget BeginOfApproach(const StopTarget& target, const std::vector<double>& from,
                           const std::vector<AxisSettings>& axes, bool approached) {
  StopTarget begin = target;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const AxisSettings& axis = axes[i];
    if (axis.approach == 0 || axis.backlash <= 0) continue;
    const double ahead = (target.axes[i] - from[i]) * axis.approach;
    const double enough = approached ? 0 : axis.backlash;
    if (ahead <= enough) begin.axes[i] -= axis.approach * axis.backlash;
  }
  return begin;
}

Result<RecordedStop> ArrivedAt(const StopTarget& target, const std::vector<double>& at,
                               const PositionerSettings& settings, const std::string& device) {
  RecordedStop stop{.id = target.id};
  for (std::size_t i = 0; i < settings.axes.size(); ++i) {
    const AxisSettings& axis = settings.axes[i];
    const double tolerance = ToleranceOf(settings, axis);
    if (!(std::abs(at[i] - target.axes[i]) <= tolerance)) {
      return Fail(ErrorCode::kDevice, "{}: axis '{}' was sent to {:.6f} and stands at {:.6f}, {:.6f} are allowed",
                  device, axis.name, target.axes[i], at[i], tolerance);
    }
    stop.axes.push_back({.axis = axis.name, .unit = axis.unit, .commanded = target.axes[i], .reported = at[i]});
  }
  return stop;
}

Result<void> CheckUnmoved(const std::vector<double>& was, const std::vector<double>& at,
                          const PositionerSettings& settings, const std::string& device) {
  for (std::size_t i = 0; i < settings.axes.size(); ++i) {
    if (std::abs(at[i] - was[i]) <= ToleranceOf(settings, settings.axes[i])) continue;
    return Fail(ErrorCode::kDevice,
                "{}: axis '{}' stood at {:.6f} and says {:.6f} now without having been moved: it was reset or moved by "
                "somebody",
                device, settings.axes[i].name, was[i], at[i]);
  }
  return {};
}

}  // namespace rigcal
