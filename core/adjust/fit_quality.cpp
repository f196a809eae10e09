#include "core/adjust/fit_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rigcal {
namespace {

/// Median length of a 2-D normal vector of unit sigma: sqrt(2 ln 2).
constexpr double kMedianOfRayleigh = 1.1774100225;
/// A feature this many robust sigmas off is wrong, not noisy: with a Cauchy loss it has a weight below 5 % by then.
constexpr double kGrossErrorSigmas = 6;

/// Renumbers the points so that those without measurements are gone.
void RemoveUnmeasuredPoints(MeasurementSet& measurements) {
  MeasurementSet kept;
  int last_point = -1;
  for (const Measurement& m : measurements.items) {
    if (m.point != last_point) {
      kept.x_in_world.push_back(measurements.x_in_world[m.point]);
      kept.track.push_back(measurements.track[m.point]);
      last_point = m.point;
    }
    kept.items.push_back(m);
    kept.items.back().point = static_cast<int>(kept.track.size()) - 1;
  }
  measurements = std::move(kept);
}

}  // namespace

FitResiduals ResidualsOf(const RigCalibration& calibration, const MeasurementSet& measurements) {
  FitResiduals residuals;
  residuals.px.reserve(measurements.items.size());
  residuals.sigmas.reserve(measurements.items.size());
  for (const Measurement& m : measurements.items) {
    const auto x_px = Project(calibration.CameraOf(m.view),
                              calibration.views[m.view].cam_from_world * measurements.x_in_world[m.point]);
    const Eigen::Vector2d error_px =
        x_px ? Eigen::Vector2d(*x_px - m.x_px) : Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    residuals.px.push_back(error_px.norm());
    residuals.sigmas.push_back(x_px ? (m.whitening * error_px).norm() : error_px.x());
  }
  return residuals;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<bool> DropGrossErrors(const FitResiduals& residuals, double least_sigmas, int num_views,
                                  MeasurementSet& measurements) {
  std::vector<std::vector<double>> by_view(num_views);
  std::vector<int> num_good(measurements.x_in_world.size(), 0);
  for (std::size_t i = 0; i < measurements.items.size(); ++i) {
    by_view[measurements.items[i].view].push_back(residuals.sigmas[i]);
  }
  const double of_all = Median(residuals.sigmas);
  std::vector<double> limit;
  for (const auto& view : by_view) {
    limit.push_back(std::max(least_sigmas, kGrossErrorSigmas / kMedianOfRayleigh * std::max(of_all, Median(view))));
  }
  std::vector<bool> dropped(measurements.items.size());
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    const Measurement& m = measurements.items[i];
    dropped[i] = !(residuals.sigmas[i] <= limit[m.view]) || !std::isfinite(residuals.sigmas[i]);
    if (!dropped[i]) ++num_good[m.point];
  }
  std::vector<Measurement> kept;
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    const Measurement& m = measurements.items[i];
    if (num_good[m.point] < 2) dropped[i] = true;
    if (!dropped[i]) kept.push_back(m);
  }
  measurements.items = std::move(kept);
  RemoveUnmeasuredPoints(measurements);
  return dropped;
}

NoiseEstimate EstimateNoise(const std::vector<double>& residual_sigmas, double cauchy_scale, int num_estimated) {
  NoiseEstimate noise;
  const double inverse_scale2 = cauchy_scale > 0 ? 1 / (cauchy_scale * cauchy_scale) : 0;
  double sum_psi2 = 0, sum_psi_slope = 0, sum_weight = 0;
  for (const double residual : residual_sigmas) {
    const double s = residual * residual;
    const double w = 1 / (1 + s * inverse_scale2);
    noise.weight.push_back(w);
    sum_psi2 += 0.5 * w * w * s;                      // one coordinate's share of |psi|^2 = (w |e|)^2
    sum_psi_slope += w - w * w * s * inverse_scale2;  // half the trace of d psi / d e
    sum_weight += w;
  }
  const double n = static_cast<double>(residual_sigmas.size());
  const double degrees_of_freedom = std::max(1.0, 2 * n - num_estimated);
  if (n == 0) return noise;
  const double slope = sum_psi_slope / n;
  const double variance = sum_psi2 / n / (slope * slope) * (2 * n / degrees_of_freedom);
  noise.sigma = std::sqrt(variance);
  noise.weighted_sigma = std::sqrt(variance * sum_weight / n);
  return noise;
}

}  // namespace rigcal
