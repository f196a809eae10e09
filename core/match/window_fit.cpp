#include "core/match/window_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

/// Root mean square contrast (grey values in [0, 1]) below which a window shows nothing but the rounding of an 8-bit
/// camera, 1 / (255 sqrt(12)).
constexpr float kMinContrast = 0.0012f;

/// Gauss-Newton stops when a step is shorter than this, far below the accuracy that noise allows (0.02 px).
constexpr double kConvergedPx = 0.002;
constexpr int kMaxIterations = 15;
/// The linearisation holds for about half the width of the kernel-smoothed texture's details.
constexpr double kMaxStepPx = 0.75;
/// Share of the information's trace that is added to its diagonal: along an edge the feature stays where it is.
constexpr double kDamping = 1e-3;
/// An optimisation that ends with less NCC than it began with (beyond rounding and noise) went astray.
constexpr float kMaxNccLoss = 0.01f;

const CubicKernel& Kernel() {
  return kCubicBSpline;
}

/// d v / d shift, where v is the normalised texture and `derivative` the derivative of the texture before:
/// (I - v v^T) (derivative - mean) / norm.
void DifferentiateNormalised(const WindowShape& shape, const WindowValues& v, float norm, WindowValues& derivative) {
  const int n = shape.NumSamples();
  float mean = 0, along = 0;
  for (int k = 0; k < n; ++k) mean += derivative[k];
  mean /= static_cast<float>(n);
  for (int k = 0; k < n; ++k) along += derivative[k] * v[k];
  for (int k = 0; k < n; ++k) derivative[k] = (derivative[k] - mean - along * v[k]) / norm;
  for (int k = n; k < shape.NumLanes(); ++k) derivative[k] = 0;
}

}  // namespace

std::optional<WindowTemplate> MakeTemplate(const cv::Mat1f& image, const WindowShape& shape,
                                           const Eigen::Vector2d& centre_px) {
  if (!WindowFits(image, shape, centre_px)) return std::nullopt;
  WindowTemplate t;
  t.shape = shape;
  WindowValues by_x, by_y;
  SampleWindowWithGradient(image, shape, centre_px, Kernel(), t.values, by_x, by_y);
  const auto norm = Normalise(shape, kMinContrast, t.values);
  if (!norm) return std::nullopt;
  const Eigen::Matrix2f a = shape.px_from_step.cast<float>();
  for (int k = 0; k < shape.NumLanes(); ++k) {
    t.by_u[k] = by_x[k] * a(0, 0) + by_y[k] * a(1, 0);
    t.by_v[k] = by_x[k] * a(0, 1) + by_y[k] * a(1, 1);
  }
  DifferentiateNormalised(shape, t.values, *norm, t.by_u);
  DifferentiateNormalised(shape, t.values, *norm, t.by_v);
  const double uv = Dot(shape, t.by_u, t.by_v);
  t.information << Dot(shape, t.by_u, t.by_u), uv, uv, Dot(shape, t.by_v, t.by_v);
  if (!(t.information.trace() > 0)) return std::nullopt;
  return t;
}

std::optional<float> NccAt(const cv::Mat1f& image, const WindowShape& shape, const WindowTemplate& reference,
                           const Eigen::Vector2d& centre_px, WindowValues& values) {
  if (!WindowFits(image, shape, centre_px)) return std::nullopt;
  SampleWindow(image, shape, centre_px, Kernel(), values);
  if (!Normalise(shape, kMinContrast, values)) return std::nullopt;
  return Dot(shape, values, reference.values);
}

std::optional<WindowFit> FitWindow(const cv::Mat1f& image, const WindowShape& shape, const WindowTemplate& reference,
                                   const Eigen::Vector2d& start_px, double max_move_px) {
  const Eigen::Matrix2d damped =
      reference.information + kDamping * reference.information.trace() * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d px_from_gradient = shape.px_from_step * damped.inverse();
  WindowFit fit;
  fit.centre_px = start_px;
  std::optional<float> first_ncc;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const auto ncc = NccAt(image, shape, reference, fit.centre_px, fit.residual);
    if (!ncc) return std::nullopt;
    if (!first_ncc) first_ncc = ncc;
    fit.ncc = *ncc;
    for (int k = 0; k < shape.NumLanes(); ++k) fit.residual[k] -= reference.values[k];
    const Eigen::Vector2d gradient(Dot(shape, reference.by_u, fit.residual), Dot(shape, reference.by_v, fit.residual));
    Eigen::Vector2d step_px = px_from_gradient * gradient;
    const double length = step_px.norm();
    if (length < kConvergedPx) {
      if (fit.ncc < *first_ncc - kMaxNccLoss) return std::nullopt;
      return fit;
    }
    if (length > kMaxStepPx) step_px *= kMaxStepPx / length;
    fit.centre_px -= step_px;
    if (!((fit.centre_px - start_px).norm() <= max_move_px)) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace rigcal
