#include "drivers/linuxcnc/mdi_move.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace rigcal {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi, kMmPerMetre = 1e3, kSecondsPerMinute = 60;
constexpr double kNoWay = 1e-4;  ///< millimetres or degrees; an axis that does not move by more sets no speed

double ScaleOf(AxisUnit unit) {
  return unit == AxisUnit::kRadian ? kDegPerRad : kMmPerMetre;
}

}  // namespace

double RshFromAxis(double value, AxisUnit unit) {
  return value * ScaleOf(unit);
}

double AxisFromRsh(double value, AxisUnit unit) {
  return value / ScaleOf(unit);
}

std::string MdiMove(const RshPosition& from, const std::vector<double>& to, const std::vector<AxisSettings>& axes) {
  std::string words;
  double duration_s = 0, linear_mm = 0, angular_deg = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const AxisSettings& axis = axes[i];
    const double target = RshFromAxis(to[i], axis.unit);
    const double way = std::abs(target - from[kRshAxisLetters.find(axis.device_letter)]);
    fmt::format_to(std::back_inserter(words), " {}{:.6f}", axis.device_letter, target);
    if (way < kNoWay) continue;
    double& path = axis.unit == AxisUnit::kRadian ? angular_deg : linear_mm;
    path = std::hypot(path, way);
    if (axis.speed > 0) duration_s = std::max(duration_s, way / RshFromAxis(axis.speed, axis.unit));
  }
  if (duration_s <= 0) return "G21 G90 G94 G53 G0" + words;
  // Of a move with both kinds of axes F is the speed along the linear ones.
  const double path = linear_mm > 0 ? linear_mm : angular_deg;
  return fmt::format("G21 G90 G94 G53 G1{} F{:.6f}", words, path / duration_s * kSecondsPerMinute);
}

}  // namespace rigcal
