#include "config/rig_stops.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

using StopList = std::vector<std::vector<double>>;

constexpr double kFullTurn_deg = 360;
// Nearer than any positioner repeats: two such stops are one.
constexpr double kSameStop_rad = 1e-3 * kRadPerDeg, kSameStop_m = 1e-6;
// Radians or metres: a stop at its limit in degrees may be beyond it by rounding. Devices allow as much.
constexpr double kRounding = 1e-9;

/// The stops of a turntable and the key that says them.
Result<StopList> AnglesFrom(const CheckedTable& table) {
  const bool listed = table.Has("angles_deg");
  for (const char* key : {"count", "start_deg", "step_deg"}) {
    if (!table.Has(key)) continue;
    if (listed) return Fail(ErrorCode::kBadInput, "{}: angles_deg says every stop already", table.Place(key));
    if (!table.Has("count"))
      return Fail(ErrorCode::kBadInput, "{} needs stops.count, the number of stops", table.Place(key));
  }
  StopList stops;
  if (listed) {
    std::vector<double> angles;
    table.Read("angles_deg", angles);
    for (const double angle : angles) stops.push_back({angle});
    return stops;
  }
  int count = 0;
  table.Read("count", count);
  if (count == 0)
    return Fail(ErrorCode::kBadInput, "{} line {}: [stops] of a turntable needs angles_deg or count", table.File(),
                table.Line());
  double start = 0, step = kFullTurn_deg * kRadPerDeg / count;
  table.Read("start_deg", start);
  table.Read("step_deg", step);
  for (int s = 0; s < count; ++s) stops.push_back({start + s * step});
  return stops;
}

Result<StopList> PositionsFrom(const CheckedTable& table, std::size_t num_axes) {
  StopList stops;
  table.Read("positions_m", stops);
  if (stops.empty())
    return Fail(ErrorCode::kBadInput, "{} line {}: [stops] of a gantry needs positions_m", table.File(), table.Line());
  for (std::size_t s = 0; s < stops.size(); ++s) {
    if (stops[s].size() == num_axes) continue;
    return Fail(ErrorCode::kBadInput, "{}: stop {} has {} positions, the rig has {} axes", table.Place("positions_m"),
                s + 1, stops[s].size(), num_axes);
  }
  return stops;
}

bool AreOne(const std::vector<double>& a, const std::vector<double>& b, AxisUnit unit) {
  constexpr double kFullTurn_rad = kFullTurn_deg * kRadPerDeg;
  const auto same = [unit](double x, double y) {
    return unit == AxisUnit::kRadian ? std::abs(std::remainder(x - y, kFullTurn_rad)) < kSameStop_rad
                                     : std::abs(x - y) < kSameStop_m;
  };
  return std::ranges::equal(a, b, same);
}

std::string InFileUnit(double value, AxisUnit unit) {
  return unit == AxisUnit::kRadian ? fmt::format("{:.6g} degrees", value / kRadPerDeg)
                                   : fmt::format("{:.6g} metres", value);
}

Result<void> CheckWithinLimits(const std::string& where, std::size_t stop, double value, const AxisSettings& axis) {
  const double turning_point = value - axis.approach * axis.backlash;
  const double least = std::min(value, turning_point), most = std::max(value, turning_point);
  const auto within = [&](double lowest, double highest) {
    return (!axis.least || lowest >= *axis.least - kRounding) && (!axis.most || highest <= *axis.most + kRounding);
  };
  if (within(least, most)) return {};
  return Fail(ErrorCode::kBadInput, "{}: stop {} at {} is outside the soft limits of the axis '{}', {} to {}{}", where,
              stop + 1, InFileUnit(value, axis.unit), axis.name, InFileUnit(*axis.least, axis.unit),
              InFileUnit(*axis.most, axis.unit), within(value, value) ? ", on the way round its backlash" : "");
}

}  // namespace

Result<StopList> ReadStops(const CheckedTable& table, const std::vector<AxisSettings>& axes) {
  if (axes.empty())
    return Fail(ErrorCode::kBadInput, "{} line {}: [stops]: an arm tells its stops itself", table.File(), table.Line());
  const AxisUnit unit = axes.front().unit;
  const bool turntable = unit == AxisUnit::kRadian;
  Result<StopList> stops = turntable ? AnglesFrom(table) : PositionsFrom(table, axes.size());
  if (!stops) return stops;
  const char* const key = !turntable ? "positions_m" : table.Has("angles_deg") ? "angles_deg" : "count";
  const std::string where = table.Place(key);
  for (std::size_t s = 0; s < stops->size(); ++s) {
    for (std::size_t a = 0; a < axes.size(); ++a) {
      const Result<void> within = CheckWithinLimits(where, s, (*stops)[s][a], axes[a]);
      if (!within) return Fail(within.error());
    }
    for (std::size_t before = 0; before < s; ++before) {
      if (!AreOne((*stops)[s], (*stops)[before], unit)) continue;
      return Fail(ErrorCode::kBadInput, "{}: stop {} is stop {} again{}", where, s + 1, before + 1,
                  turntable ? ", at " + InFileUnit((*stops)[s][0], unit) : "");
    }
  }
  return stops;
}

}  // namespace rigcal
