#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/match/window_fit.h"

namespace rigcal {
namespace {

/// Samples d pixels apart share pixels: with the cubic B-spline kernel white pixel noise is correlated like
/// exp(-d^2 / (4 v)), v = 1/3 px^2 being the kernel's variance (the exact curve is the B-spline of order seven; the two
/// differ by less than 0.03).
constexpr double kKernelVariancePx2 = 1.0 / 3.0;
/// Beyond three pixels the correlation is below 0.002.
constexpr double kCorrelatedPx = 3.0;

/// Correlation of samples that lie 0, 1, 2 .. steps apart along one axis of the patch.
std::array<float, kMaxWindowPx> CorrelationAlong(double px_per_step, int side, int& reach) {
  std::array<float, kMaxWindowPx> correlation{};
  reach = std::min(side - 1, static_cast<int>(std::ceil(kCorrelatedPx / std::max(px_per_step, 1e-3))));
  for (int i = 0; i <= reach; ++i) {
    const double d = i * px_per_step;
    correlation[i] = static_cast<float>(std::exp(-d * d / (4 * kKernelVariancePx2)));
  }
  return correlation;
}

/// C * x with the separable correlation of a view in which the steps are as long as the columns of px_from_step.
WindowValues Correlate(const WindowShape& shape, const WindowValues& x) {
  const int side = shape.side;
  int reach_u = 0, reach_v = 0;
  const auto along_u = CorrelationAlong(shape.px_from_step.col(0).norm(), side, reach_u);
  const auto along_v = CorrelationAlong(shape.px_from_step.col(1).norm(), side, reach_v);
  WindowValues rows, result{};
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      float sum = 0;
      for (int m = std::max(0, i - reach_u); m <= std::min(side - 1, i + reach_u); ++m) {
        sum += along_u[std::abs(m - i)] * x[j * side + m];
      }
      rows[j * side + i] = sum;
    }
  }
  for (int j = 0; j < side; ++j) {
    for (int m = std::max(0, j - reach_v); m <= std::min(side - 1, j + reach_v); ++m) {
      for (int i = 0; i < side; ++i) result[j * side + i] += along_v[std::abs(m - j)] * rows[m * side + i];
    }
  }
  return result;
}

/// What one picture's noise does to the fit, for residuals of unit variance.
struct NoiseEffect {
  Eigen::Matrix2d on_gradient;  ///< J^T C J
  double absorbed;              ///< trace of C over what the fit took out: mean, contrast and the two shifts
};

NoiseEffect EffectOf(const WindowShape& shape, const WindowTemplate& t, const Eigen::Matrix2d& information_inverse) {
  const WindowValues cu = Correlate(shape, t.by_u), cv = Correlate(shape, t.by_v), cn = Correlate(shape, t.values);
  WindowValues ones{};
  std::fill_n(ones.begin(), shape.NumSamples(), 1.0f);
  const WindowValues c1 = Correlate(shape, ones);
  const double uv = Dot(t.shape, t.by_u, cv);
  NoiseEffect effect;
  effect.on_gradient << Dot(t.shape, t.by_u, cu), uv, uv, Dot(t.shape, t.by_v, cv);
  effect.absorbed = Dot(t.shape, ones, c1) / static_cast<float>(shape.NumSamples()) + Dot(t.shape, t.values, cn) +
                    (information_inverse * effect.on_gradient).trace();
  return effect;
}

}  // namespace

Eigen::Matrix2d FitCovariance(const WindowShape& shape, const WindowTemplate& reference, const WindowFit& fit) {
  /// Along a perfect edge nothing is known; a tenth of a thousandth of the other direction's information stands for it.
  constexpr double kMinInformationShare = 1e-4;
  const Eigen::Matrix2d information =
      reference.information + kMinInformationShare * reference.information.trace() * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d inverse = information.inverse();
  const NoiseEffect here = EffectOf(shape, reference, inverse);
  const NoiseEffect there = EffectOf(reference.shape, reference, inverse);
  const int n = shape.NumSamples();
  const double freedom = std::max(1.0, n - (here.absorbed + there.absorbed) / 2);
  const double variance = Dot(shape, fit.residual, fit.residual) / freedom;
  const Eigen::Matrix2d px_from_gradient = shape.px_from_step * inverse;
  return variance / 2 * px_from_gradient * (here.on_gradient + there.on_gradient) * px_from_gradient.transpose();
}

}  // namespace rigcal
