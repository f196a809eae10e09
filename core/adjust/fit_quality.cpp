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
  if (residual_sigmas.empty()) return noise;
  const double n = static_cast<double>(residual_sigmas.size());
  // The fit has made the residuals smaller than the errors, by this much on average.
  const double error2_per_residual2 = 2 * n / std::max(1.0, 2 * n - num_estimated);
  const double inverse_scale2 = cauchy_scale > 0 ? 1 / (cauchy_scale * cauchy_scale) : 0;
  double sum_psi2 = 0, sum_slope = 0, sum_slope2 = 0, sum_weight = 0;  // per coordinate, summed over the features
  for (const double residual : residual_sigmas) {
    const double s = error2_per_residual2 * residual * residual;
    const double w = 1 / (1 + s * inverse_scale2);
    const double across = w, along = w - 2 * w * w * s * inverse_scale2;  // eigenvalues of d psi / d e
    noise.weight.push_back(w);
    sum_psi2 += 0.5 * w * w * s;
    sum_slope += 0.5 * (across + along);
    sum_slope2 += 0.5 * (across * across + along * along);
    sum_weight += w;
  }
  const double slope = sum_slope / n;
  const double slope_variance = std::max(0.0, sum_slope2 / n - slope * slope);
  const double small_sample = 1 + num_estimated / (2 * n) * slope_variance / (slope * slope);
  const double variance = small_sample * small_sample * (sum_psi2 / n) / (slope * slope);
  noise.sigma = std::sqrt(variance);
  noise.weighted_sigma = std::sqrt(variance * sum_weight / n);
  return noise;
}

}  // namespace rigcal
