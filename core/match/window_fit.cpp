#include "core/match/window_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

/// Gauss-Newton stops when a step is shorter than this, far below the accuracy that noise allows (0.02 px).
constexpr double kConvergedPx = 0.002;
constexpr int kMaxIterations = 15;
/// The linearisation holds for about half the width of the kernel-smoothed texture's details.
constexpr double kMaxStepPx = 0.75;
/// Share of the information's trace that is added to its diagonal: along an edge the feature stays where it is.
constexpr double kDamping = 1e-3;
/// An optimisation that ends with less NCC than it began with (beyond rounding and noise) went astray.
constexpr float kMaxNccLoss = 0.01f;

}  // namespace

std::optional<float> NccAt(const cv::Mat1f& image, const WindowTemplate& sought, const Eigen::Vector2d& centre_px,
                           WindowValues& values) {
  const WindowShape& shape = sought.shape;
  if (!WindowFits(image, shape, centre_px)) return std::nullopt;
  SampleWindow(image, shape, centre_px, kMatchingKernel, values);
  if (!Normalise(shape, kMinContrast, values)) return std::nullopt;
  return Dot(shape, values, sought.values);
}

std::optional<WindowFit> FitWindow(const cv::Mat1f& image, const WindowTemplate& sought,
                                   const Eigen::Vector2d& start_px, double max_move_px) {
  const WindowShape& shape = sought.shape;
  const Eigen::Matrix2d damped =
      sought.information + kDamping * sought.information.trace() * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d px_from_gradient = shape.px_from_step * damped.inverse();
  WindowFit fit;
  fit.centre_px = start_px;
  std::optional<float> first_ncc;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const auto ncc = NccAt(image, sought, fit.centre_px, fit.residual);
    if (!ncc) return std::nullopt;
    if (!first_ncc) first_ncc = ncc;
    fit.ncc = *ncc;
    for (int k = 0; k < shape.NumLanes(); ++k) fit.residual[k] -= sought.values[k];
    const Eigen::Vector2d gradient(Dot(shape, sought.by_u, fit.residual), Dot(shape, sought.by_v, fit.residual));
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
