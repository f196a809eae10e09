#include "drivers/grbl/jog_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

namespace rigcal {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi, kMmPerMetre = 1e3;
constexpr double kSecondsPerMinute = 60;
constexpr double kNoWay = 1e-4;  ///< controller units; a tenth of what GRBL reports

double ScaleOf(AxisUnit unit) {
  return unit == AxisUnit::kRadian ? kDegPerRad : kMmPerMetre;
}

}  // namespace

double GrblFromAxis(double value, AxisUnit unit) {
  return value * ScaleOf(unit);
}

double AxisFromGrbl(double value, AxisUnit unit) {
  return value / ScaleOf(unit);
}

JogPath::JogPath(const GrblPosition& from, const GrblPosition& to, const std::vector<int>& axes,
                 const std::vector<double>& speed_per_s, const GrblMachine& machine)
    : from_(from), to_(to), axes_(axes) {
  double duration_s = 0, acceleration_per_s2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const int axis = axes[i];
    const double way = std::abs(to[axis] - from[axis]);
    length_ = std::hypot(length_, way);
    duration_s = std::max(duration_s, way / speed_per_s[i]);
    acceleration_per_s2 = std::min(acceleration_per_s2, machine.max_acceleration_per_s2[axis]);
  }
  if (length_ < kNoWay) {
    sent_ = length_;
    return;
  }
  const double speed_per_s_on_path = length_ / duration_s;
  feed_per_min_ = speed_per_s_on_path * kSecondsPerMinute;
  // GRBL plans to stop at the end of what it holds: with less than the way of braking it never gets up to speed.
  const double braking = speed_per_s_on_path * speed_per_s_on_path / (2 * acceleration_per_s2);
  lead_ = speed_per_s_on_path * kLead_s + braking;
  segment_ = std::max(speed_per_s_on_path * kSegment_s, lead_ / kMostQueued);
}

double JogPath::Done(const GrblPosition& position) const {
  double along = 0;
  for (const int axis : axes_) along += (position[axis] - from_[axis]) * (to_[axis] - from_[axis]);
  return length_ > 0 ? along / length_ : 0;
}

std::string JogPath::NextJog(const GrblPosition& position) {
  if (AllSent() || sent_ >= Done(position) + lead_) return "";
  sent_ = length_ - sent_ < 1.5 * segment_ ? length_ : sent_ + segment_;  // the last one is no sliver
  std::string jog = "$J=G90G21";
  for (const int axis : axes_) {
    const double target = AllSent() ? to_[axis] : from_[axis] + (to_[axis] - from_[axis]) * (sent_ / length_);
    fmt::format_to(std::back_inserter(jog), "{}{:.4f}", kGrblAxisLetters[axis], target);
  }
  fmt::format_to(std::back_inserter(jog), "F{:.3f}", feed_per_min_);
  return jog;
}

}  // namespace rigcal
