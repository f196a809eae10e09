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

/// Along a perfect edge nothing is known; a ten-thousandth of the information across stands for it.
constexpr double kMinInformationShare = 1e-4;

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
WindowValues Correlate(const Eigen::Matrix2d& px_from_step, int side, const WindowValues& x) {
  int reach_u = 0, reach_v = 0;
  const auto along_u = CorrelationAlong(px_from_step.col(0).norm(), side, reach_u);
  const auto along_v = CorrelationAlong(px_from_step.col(1).norm(), side, reach_v);
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

NoiseEffect EffectOf(const Eigen::Matrix2d& px_from_step, const WindowTemplate& t,
                     const Eigen::Matrix2d& information_inverse) {
  const WindowShape& shape = t.shape;
  const auto correlate = [&](const WindowValues& x) { return Correlate(px_from_step, shape.side, x); };
  WindowValues ones{};
  std::fill_n(ones.begin(), shape.NumSamples(), 1.0f);
  const WindowValues c_by_u = correlate(t.by_u), c_by_v = correlate(t.by_v);
  const double uv = Dot(shape, t.by_u, c_by_v);
  NoiseEffect effect;
  effect.on_gradient << Dot(shape, t.by_u, c_by_u), uv, uv, Dot(shape, t.by_v, c_by_v);
  effect.absorbed = Dot(shape, ones, correlate(ones)) / static_cast<float>(shape.NumSamples()) +
                    Dot(shape, t.values, correlate(t.values)) + (information_inverse * effect.on_gradient).trace();
  return effect;
}

/// The inverse of J^T J without the part of it that noise in the reference picture has put there: noise has gradients
/// too, but they do not answer to a shift of the other picture. `value_variance`: of that noise in the template.
Eigen::Matrix2d InverseOfSignal(const WindowTemplate& t, double value_variance) {
  /// Least share of an eigenvalue that counts as signal, so that a bad guess of the noise costs a factor of four at
  /// most.
  constexpr double kMinSignalShare = 0.25;
  // Minus the second derivative of the correlation at zero distance: variance of the gradient over variance of the
  // value.
  constexpr double kGradientPerValue = 1 / (2 * kKernelVariancePx2);
  const Eigen::Matrix2d& a = t.reference_px_from_step;
  const Eigen::Matrix2d of_noise = t.shape.NumSamples() * kGradientPerValue * value_variance * a.transpose() * a;
  const Eigen::Matrix2d least = kMinInformationShare * t.information.trace() * Eigen::Matrix2d::Identity();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(t.information + least);
  const Eigen::Matrix2d inverse_root = eigen.operatorInverseSqrt();
  eigen.computeDirect(Eigen::Matrix2d::Identity() - inverse_root * of_noise * inverse_root);
  return inverse_root * eigen.eigenvectors() *
         eigen.eigenvalues().cwiseMax(kMinSignalShare).cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
         inverse_root;
}

}  // namespace

Eigen::Matrix2d FitCovariance(const WindowTemplate& sought, const WindowFit& fit) {
  const WindowShape& shape = sought.shape;
  const Eigen::Matrix2d inverse = InverseOfSignal(sought, 0);
  const NoiseEffect here = EffectOf(shape.px_from_step, sought, inverse);
  const NoiseEffect there = EffectOf(sought.reference_px_from_step, sought, inverse);
  const double freedom = std::max(1.0, shape.NumSamples() - (here.absorbed + there.absorbed) / 2);
  const double variance = Dot(shape, fit.residual, fit.residual) / freedom;
  // Where J is nothing but zero (a perfect edge), the residual still is what it is.
  const Eigen::Matrix2d least = kMinInformationShare * sought.information.trace() * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d on_gradient = (here.on_gradient + there.on_gradient) / 2 + least;
  const Eigen::Matrix2d px_from_gradient = shape.px_from_step * InverseOfSignal(sought, variance / 2);
  return variance * px_from_gradient * on_gradient * px_from_gradient.transpose();
}

}  // namespace rigcal
