#include "core/mvs/fit_plane.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace rigcal::stereo {
namespace {

/// Variance of one normalised grey value times the number of samples at NCC = 0.9: the scale on which the offsets'
/// prior is weighed against the textures.
constexpr double kResidualEnergy = 0.2;
/// Least error of a camera and least length of a step that are divided by.
constexpr double kTinyPx = 0.01;
/// No step moves the window's centre further than this in any view: the reach of a linearised texture.
constexpr double kMaxStepPx = 1.5;
constexpr double kFirstDamping = 1e-3, kMaxDamping = 1e3;

struct Linearised {
  double cost = 0;
  double shift_per_w = 0;  ///< largest shift of the centre, in pixels of any view, per unit of inverse depth
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  struct Offset {
    Eigen::Matrix2d hessian_inverse;
    Eigen::Matrix<double, 2, 3> cross;
    Eigen::Vector2d gradient;
    bool seen = false;
  };
  std::vector<Offset> offsets;
};

/// Adds one view with its offset eliminated (Schur complement), remembering how to get it back.
void AddWithOffset(const ViewNormalEquations& view, double prior, const Eigen::Vector2f& offset_px, Linearised& sum,
                   Linearised::Offset& back) {
  const Eigen::Matrix<double, 2, 2> offset_hessian =
      view.hessian.bottomRightCorner<2, 2>() + prior * Eigen::Matrix2d::Identity();
  back.hessian_inverse = offset_hessian.inverse();
  back.cross = view.hessian.bottomLeftCorner<2, 3>();
  back.gradient = view.gradient.tail<2>() + prior * offset_px.cast<double>();
  back.seen = true;
  sum.cost += prior * offset_px.cast<double>().squaredNorm();
  const Eigen::Matrix<double, 3, 2> gain = back.cross.transpose() * back.hessian_inverse;
  sum.hessian += view.hessian.topLeftCorner<3, 3>() - gain * back.cross;
  sum.gradient += view.gradient.head<3>() - gain * back.gradient;
}

Linearised LineariseAll(const StereoScene& scene, const WindowTexture& reference, PlaneFit& fit) {
  Linearised sum;
  sum.offsets.resize(fit.others.size());
  for (std::size_t i = 0; i < fit.others.size(); ++i) {
    Sighting& sighting = fit.others[i];
    sighting.ncc = 0;
    const std::optional<WindowWarp> warp = MakeWarp(scene, fit.plane, sighting.view, sighting.offset_px);
    std::optional<ViewNormalEquations> view;
    if (warp) {
      view = LineariseWindow(scene.views[sighting.view].texels, scene.options.window_px, *warp, reference,
                             scene.free_offsets);
    }
    if (!view) {
      sum.cost += 2;  // |f_j - f_r|^2 of unrelated textures
      continue;
    }
    sighting.ncc = view->ncc;
    sum.cost += 2 - 2 * static_cast<double>(view->ncc);
    sum.shift_per_w = std::max(sum.shift_per_w, static_cast<double>(warp->CentreByInverseDepth().norm()));
    if (scene.free_offsets) {
      const double error_px = std::max(scene.views[sighting.view].error_px, kTinyPx);
      AddWithOffset(*view,
                    kResidualEnergy / (scene.options.window_px * scene.options.window_px) / (error_px * error_px),
                    sighting.offset_px, sum, sum.offsets[i]);
    } else {
      sum.hessian += view->hessian.topLeftCorner<3, 3>();
      sum.gradient += view->gradient.head<3>();
    }
  }
  return sum;
}

/// The damped step of the plane; its length as the largest shift of the window's edge.
Eigen::Vector3d PlaneStep(const Linearised& at, double damping) {
  Eigen::Matrix3d damped = at.hessian;
  damped.diagonal() *= 1 + damping;
  return damped.ldlt().solve(-at.gradient);
}

double StepLengthPx(const Linearised& at, const Eigen::Vector3d& step, int window_px) {
  return at.shift_per_w * (std::abs(step[0]) + 0.5 * window_px * std::max(std::abs(step[1]), std::abs(step[2])));
}

void Apply(const Linearised& at, const Eigen::Vector3d& step, double share, PlaneFit& fit) {
  fit.plane.inverse_depth += share * step;
  for (std::size_t i = 0; i < fit.others.size(); ++i) {
    const Linearised::Offset& back = at.offsets[i];
    if (!back.seen) continue;
    fit.others[i].offset_px -= (share * (back.hessian_inverse * (back.gradient + back.cross * step))).cast<float>();
  }
}

}  // namespace

bool FitPlane(const StereoScene& scene, const WindowTexture& reference, int max_iterations, double converged_px,
              PlaneFit& fit) {
  Linearised at = LineariseAll(scene, reference, fit);
  double damping = kFirstDamping;
  for (int i = 0; i < max_iterations && damping < kMaxDamping; ++i) {
    if (!(at.shift_per_w > 0)) return false;
    const Eigen::Vector3d step = PlaneStep(at, damping);
    const double length_px = StepLengthPx(at, step, scene.options.window_px);
    if (!std::isfinite(length_px)) return false;
    PlaneFit trial = fit;
    Apply(at, step, std::min(1.0, kMaxStepPx / std::max(length_px, kTinyPx)), trial);
    if (!(trial.plane.inverse_depth[0] > 0)) return false;
    if (length_px < converged_px) {
      fit = std::move(trial);
      break;
    }
    Linearised there = LineariseAll(scene, reference, trial);
    if (there.cost < at.cost) {
      fit = std::move(trial);
      at = std::move(there);
      damping *= 0.1;
    } else {
      damping *= 10;
    }
  }
  const Eigen::Matrix3d inverse = at.hessian.inverse();
  const int window_px = scene.options.window_px;
  const double samples = static_cast<double>(window_px * window_px) * static_cast<double>(fit.others.size());
  fit.sigma_px = at.shift_per_w * std::sqrt(std::max(0.0, inverse(0, 0)) * at.cost / std::max(1.0, samples - 3));
  return at.shift_per_w > 0 && std::isfinite(fit.sigma_px);
}

}  // namespace rigcal::stereo
