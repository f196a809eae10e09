#include "core/mvs/window.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "core/mvs/window_samples.h"

namespace rigcal::stereo {
namespace {

/// Largest ratio of a window's side in a view to its side in the reference: beyond, bilinear samples alias.
constexpr float kMaxScale = 2.5f;
/// A window's plane must not be seen more obliquely than this in its reference (cosine; about 80 degrees).
constexpr double kMinCosine = 0.17;
/// Standard deviation of a window's weights, in window sides.
constexpr float kWeightSigma = 0.35f;

/// Takes the weighted mean off, weighs, and scales to norm 1, which it returns; nothing when there is nothing to scale.
std::optional<float> Normalise(const WindowTexture& weights, WindowSamples& samples) {
  samples = weights.root_weight * (samples - (weights.weight * samples).sum());
  const float norm = std::sqrt(samples.square().sum());
  if (!(norm > kMinWindowContrast)) return std::nullopt;
  samples *= 1 / norm;
  return norm;
}

}  // namespace

std::optional<WindowPlane> PlaneThrough(const StereoScene& scene, int reference_view, int u_px, int v_px,
                                        const Eigen::Vector3d& point_in_world, const Eigen::Vector3d& normal_in_world) {
  const StereoView& view = scene.views[reference_view];
  const Eigen::Vector3d pixel(u_px, v_px, 1);
  const Eigen::Vector3d ray = view.direction_from_px * pixel;
  const double facing = -normal_in_world.dot(ray) / ray.norm();
  const double distance = normal_in_world.dot(view.centre_in_world - point_in_world);
  if (!(facing > kMinCosine) || !(distance > 0)) return std::nullopt;
  // On the plane n.(C + z D (u,v,1) - X) = 0, hence 1/z = -n^T D (u,v,1) / n.(C - X).
  const Eigen::Vector3d k = -(view.direction_from_px.transpose() * normal_in_world) / distance;
  return WindowPlane{reference_view, u_px, v_px, {k.dot(pixel), k.x(), k.y()}};
}

Eigen::Vector3d CentreInWorld(const StereoScene& scene, const WindowPlane& plane) {
  const StereoView& view = scene.views[plane.reference_view];
  return view.centre_in_world +
         view.direction_from_px * Eigen::Vector3d(plane.u_px, plane.v_px, 1) / plane.inverse_depth[0];
}

Eigen::Vector3d NormalInWorld(const StereoScene& scene, const WindowPlane& plane) {
  const Eigen::Vector3d& w = plane.inverse_depth;
  const Eigen::Vector3d k(w[1], w[2], w[0] - w[1] * plane.u_px - w[2] * plane.v_px);
  return -(scene.views[plane.reference_view].px_from_world.leftCols<3>().transpose() * k).normalized();
}

std::optional<WindowTexture> ReferenceTexture(const StereoScene& scene, const WindowPlane& plane) {
  const cv::Mat4f& texels = scene.views[plane.reference_view].texels;
  const int side = scene.options.window_px, h = side / 2;
  if (plane.u_px < h || plane.v_px < h || plane.u_px + h >= texels.cols || plane.v_px + h >= texels.rows) {
    return std::nullopt;
  }
  WindowTexture texture;
  texture.weight.resize(side * side);
  texture.normalised.resize(side * side);
  const float falloff = 1 / (2 * kWeightSigma * kWeightSigma * static_cast<float>(side * side));
  int k = 0;
  for (int dv = -h; dv <= h; ++dv) {
    const float* p = texels.ptr<float>(plane.v_px + dv) + 4 * (plane.u_px - h);
    for (int du = -h; du <= h; ++du, ++k, p += 4) {
      texture.normalised[k] = p[0];
      texture.weight[k] = p[3] * std::exp(-static_cast<float>(du * du + dv * dv) * falloff);
    }
  }
  const float sum = texture.weight.sum();
  if (!(sum > 0)) return std::nullopt;
  texture.weight *= 1 / sum;
  texture.root_weight = texture.weight.sqrt();
  if (!Normalise(texture, texture.normalised)) return std::nullopt;
  return texture;
}

std::optional<WindowWarp> MakeWarp(const StereoScene& scene, const WindowPlane& plane, int view,
                                   const Eigen::Vector2f& offset_px) {
  const PairGeometry& pair = scene.Pair(plane.reference_view, view);
  const Eigen::Vector3d& w = plane.inverse_depth;
  const Eigen::Vector3d centre =
      pair.infinite_homography * Eigen::Vector3d(plane.u_px, plane.v_px, 1) + w[0] * pair.epipole;
  if (!(centre.z() > 0)) return std::nullopt;
  const double scale = 1 / centre.z();
  WindowWarp warp;
  warp.centre = (centre * scale).cast<float>();
  warp.by_u = ((pair.infinite_homography.col(0) + w[1] * pair.epipole) * scale).cast<float>();
  warp.by_v = ((pair.infinite_homography.col(1) + w[2] * pair.epipole) * scale).cast<float>();
  warp.epipole = (pair.epipole * scale).cast<float>();
  warp.offset_px = offset_px;
  const Eigen::Matrix2f by_px = warp.PxByReferencePx();
  const bool too_large = by_px.col(0).norm() > kMaxScale || by_px.col(1).norm() > kMaxScale;
  if (too_large || !(std::abs(by_px.determinant()) > 1 / (kMaxScale * kMaxScale))) return std::nullopt;
  return warp;
}

std::optional<float> WindowNcc(const cv::Mat4f& texels, int window_px, const WindowWarp& warp,
                               const WindowTexture& reference) {
  if (!CanSampleWindow(texels, window_px, warp)) return std::nullopt;
  WindowPlaces<kMaxStereoWindowPx> places;
  PlaceWindow(window_px, warp, places);
  WindowSamples values(reference.NumSamples());
  for (int k = 0; k < reference.NumSamples(); ++k) values[k] = SampleGray(texels, places.x[k], places.y[k]);
  if (!Normalise(reference, values)) return 0.0f;
  return (values * reference.normalised).sum();
}

std::optional<ViewNormalEquations> LineariseWindow(const cv::Mat4f& texels, int window_px, const WindowWarp& warp,
                                                   const WindowTexture& reference, bool with_offset) {
  if (!CanSampleWindow(texels, window_px, warp)) return std::nullopt;
  const int n = reference.NumSamples();
  WindowPlaces<kMaxStereoWindowPx> places;
  PlaceWindow(window_px, warp, places);
  // Derivative of the grey value by w, dw/du, dw/dv, offset x, offset y.
  std::array<WindowSamples, 5> by;
  for (WindowSamples& column : by) column.resize(n);
  WindowSamples values(n);
  for (int k = 0; k < n; ++k) {
    const Eigen::Array4f texel = SampleTexel(texels, places.x[k], places.y[k]);
    values[k] = texel[0], by[3][k] = texel[1], by[4][k] = texel[2];
  }
  const int h = window_px / 2;
  for (int row = 0, k = 0; row < window_px; ++row) {
    for (int i = 0; i < window_px; ++i, ++k) {
      by[0][k] =
          places.scale[k] * (by[3][k] * (warp.epipole.x() - (places.x[k] - warp.offset_px.x()) * warp.epipole.z()) +
                             by[4][k] * (warp.epipole.y() - (places.y[k] - warp.offset_px.y()) * warp.epipole.z()));
      by[1][k] = by[0][k] * static_cast<float>(i - h);
      by[2][k] = by[0][k] * static_cast<float>(row - h);
    }
  }
  const std::optional<float> norm = Normalise(reference, values);
  if (!norm) return std::nullopt;
  // f = (I - mean) / |I - mean|, so df = (P dI) / norm with P the projector across 1 and f; P f = 0 removes f_j itself
  // from the gradient of |f_j - f_r|^2 / 2.
  ViewNormalEquations equations;
  equations.ncc = (values * reference.normalised).sum();
  equations.hessian.setZero();
  equations.gradient.setZero();
  const int columns = with_offset ? 5 : 3;
  std::array<float, 5> along_f{};
  for (int c = 0; c < columns; ++c) {
    by[c] = reference.root_weight * ((by[c] - (reference.weight * by[c]).sum()) * (1 / *norm));
    along_f[c] = (by[c] * values).sum();
    equations.gradient[c] = along_f[c] * equations.ncc - (by[c] * reference.normalised).sum();
    for (int b = 0; b <= c; ++b) {
      equations.hessian(b, c) = equations.hessian(c, b) = (by[b] * by[c]).sum() - along_f[b] * along_f[c];
    }
  }
  return equations;
}

}  // namespace rigcal::stereo
