#include "core/drift/drift_trend.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace rigcal {
namespace {

struct Point {
  double time_days, value, sigma;
};

struct Slope {
  double value, sigma;
};

std::optional<Slope> SlopeOf(const std::vector<Point>& points) {
  double weight_sum = 0, time_sum = 0, value_sum = 0;
  for (const Point& p : points) {
    if (!(p.sigma > 0) || !std::isfinite(p.sigma)) return std::nullopt;
    const double weight = 1 / (p.sigma * p.sigma);
    weight_sum += weight, time_sum += weight * p.time_days, value_sum += weight * p.value;
  }
  if (!(weight_sum > 0)) return std::nullopt;
  const double mean_time = time_sum / weight_sum, mean_value = value_sum / weight_sum;
  double spread = 0, moment = 0;
  for (const Point& p : points) {
    const double weight = 1 / (p.sigma * p.sigma), from_mean = p.time_days - mean_time;
    spread += weight * from_mean * from_mean;
    moment += weight * from_mean * (p.value - mean_value);
  }
  if (!(spread > 0)) return std::nullopt;
  return Slope{moment / spread, 1 / std::sqrt(spread)};
}

std::vector<std::string> CamerasOf(const std::vector<DriftNight>& nights) {
  std::vector<std::string> cameras;
  for (const DriftNight& night : nights) {
    for (const NightlyShift& shift : night.cameras) {
      if (std::ranges::find(cameras, shift.camera) == cameras.end()) cameras.push_back(shift.camera);
    }
  }
  return cameras;
}

std::optional<CameraTrend> TrendOfCamera(const std::vector<DriftNight>& nights, const std::string& camera) {
  std::vector<Point> of_axis[2];
  for (const DriftNight& night : nights) {
    const auto shift = std::ranges::find(night.cameras, camera, &NightlyShift::camera);
    if (shift == night.cameras.end()) continue;
    for (const int k : {0, 1}) of_axis[k].push_back({night.time_days, shift->shift_px[k], shift->sigma_px[k]});
  }
  CameraTrend trend{.camera = camera, .num_nights = static_cast<int>(of_axis[0].size())};
  for (const int k : {0, 1}) {
    const auto slope = SlopeOf(of_axis[k]);
    if (!slope) return std::nullopt;
    trend.px_per_day[k] = slope->value, trend.sigma_px_per_day[k] = slope->sigma;
  }
  return trend;
}

}  // namespace

std::vector<CameraTrend> TrendOf(const std::vector<DriftNight>& nights) {
  std::vector<CameraTrend> trends;
  for (const std::string& camera : CamerasOf(nights)) {
    if (auto trend = TrendOfCamera(nights, camera)) trends.push_back(std::move(*trend));
  }
  return trends;
}

}  // namespace rigcal
