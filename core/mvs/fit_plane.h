#pragma once

#include <vector>

#include "core/mvs/window.h"

namespace rigcal::stereo {

/// A view in which a patch is seen.
struct Sighting {
  int view = 0;
  Eigen::Vector2f offset_px = Eigen::Vector2f::Zero();  ///< from the centre's projection to where the texture lies
  float ncc = 0;                                        ///< with the reference view
};

/// A plane and the views (without the reference) whose textures it shall explain.
struct PlaneFit {
  WindowPlane plane;
  std::vector<Sighting> others;  ///< offsets are relative to the reference, which has none
  /// Standard deviation of the centre along the reference's ray, as the largest shift in pixels that it means in any of
  /// the views. From the curvature of the fit and its residuals.
  double sigma_px = 0;
};

/// Moves the plane (depth and two slopes) and, with scene.free_offsets, each view's offset to
///   min sum_j |f_j - f_r|^2 + (residual variance) * |offset_j|^2 / error_j^2,
/// f being textures with mean 0 and norm 1 (hence mean NCC to its maximum), by Levenberg-Marquardt. A view whose window
/// leaves its image keeps ncc = 0. Ends after max_iterations or with a step below converged_px (in every view), which
/// is still taken; the NCCs are those before it. False when nothing is left to fit.
bool FitPlane(const StereoScene& scene, const WindowTexture& reference, int max_iterations, double converged_px,
              PlaneFit& fit);

}  // namespace rigcal::stereo
