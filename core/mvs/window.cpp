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

/// A sample's weight is the product of those of its column and its row.
float OffsetWeight(int offset_px, int window_px) {
  const float d = static_cast<float>(offset_px) / (kWeightSigma * static_cast<float>(window_px));
  return std::exp(-0.5f * d * d);
}

/// Takes the weighted mean off, weighs, and scales to norm 1, which it returns; nothing when there is nothing to scale.
template <typename Samples>
std::optional<float> Normalise(const Samples& weight, const Samples& root_weight, Samples& samples) {
  samples = root_weight * (samples - (weight * samples).sum());
  const float norm = std::sqrt(samples.square().sum());
  if (!(norm > kMinWindowContrast)) return std::nullopt;
  samples *= 1 / norm;
  return norm;
}

template <int kSide>
float NccOf(const cv::Mat1f& gray, const WindowWarp& warp, const WindowTexture& reference) {
  using Shape = WindowShape<kSide>;
  static const typename Shape::Grid kGrid;
  typename Shape::Places places(warp, kGrid);
  places.x += warp.offset_px.x(), places.y += warp.offset_px.y();
  typename Shape::Samples values;
  SampleGrays(gray, places.x.data(), places.y.data(), Shape::kNumSamples, values.data());
  const typename Shape::Samples weight = typename Shape::ConstMap(reference.weight.data());
  const typename Shape::Samples root_weight = typename Shape::ConstMap(reference.root_weight.data());
  if (!Normalise(weight, root_weight, values)) return 0;
  return (values * typename Shape::ConstMap(reference.normalised.data())).sum();
}

template <int kSide>
std::optional<ViewNormalEquations> LineariseOf(const cv::Mat4f& texels, const WindowWarp& warp,
                                               const WindowTexture& reference, bool with_offset) {
  using Shape = WindowShape<kSide>;
  using Samples = typename Shape::Samples;
  static const typename Shape::Grid kGrid;
  const typename Shape::Places places(warp, kGrid);
  // Derivative of the grey value by w, dw/du, dw/dv, offset x, offset y.
  std::array<Samples, 5> by;
  Samples values;
  for (int k = 0; k < Shape::kNumSamples; ++k) {
    const Eigen::Array4f texel =
        SampleTexel(texels, places.x[k] + warp.offset_px.x(), places.y[k] + warp.offset_px.y());
    values[k] = texel[0], by[3][k] = texel[1], by[4][k] = texel[2];
  }
  by[0] = places.scale * (by[3] * (warp.epipole.x() - places.x * warp.epipole.z()) +
                          by[4] * (warp.epipole.y() - places.y * warp.epipole.z()));
  by[1] = by[0] * kGrid.du;
  by[2] = by[0] * kGrid.dv;
  const Samples weight = typename Shape::ConstMap(reference.weight.data());
  const Samples root_weight = typename Shape::ConstMap(reference.root_weight.data());
  const Samples normalised = typename Shape::ConstMap(reference.normalised.data());
  const std::optional<float> norm = Normalise(weight, root_weight, values);
  if (!norm) return std::nullopt;
  // f = (I - mean) / |I - mean|, so df = (P dI) / norm with P the projector across 1 and f; P f = 0 removes f_j itself
  // from the gradient of |f_j - f_r|^2 / 2.
  ViewNormalEquations equations;
  equations.ncc = (values * normalised).sum();
  equations.hessian.setZero();
  equations.gradient.setZero();
  const int columns = with_offset ? 5 : 3;
  std::array<float, 5> along_f{};
  for (int c = 0; c < columns; ++c) {
    by[c] = root_weight * ((by[c] - (weight * by[c]).sum()) * (1 / *norm));
    along_f[c] = (by[c] * values).sum();
    equations.gradient[c] = along_f[c] * equations.ncc - (by[c] * normalised).sum();
    for (int b = 0; b <= c; ++b) {
      equations.hessian(b, c) = equations.hessian(c, b) = (by[b] * by[c]).sum() - along_f[b] * along_f[c];
    }
  }
  return equations;
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
  texture.weight.setZero(PaddedSamples(side));
  texture.normalised.setZero(PaddedSamples(side));
  int k = 0;
  for (int dv = -h; dv <= h; ++dv) {
    const float* p = texels.ptr<float>(plane.v_px + dv) + 4 * (plane.u_px - h);
    for (int du = -h; du <= h; ++du, ++k, p += 4) {
      texture.normalised[k] = p[0];
      texture.weight[k] = p[3] * OffsetWeight(du, side) * OffsetWeight(dv, side);
    }
  }
  const float sum = texture.weight.sum();
  if (!(sum > 0)) return std::nullopt;
  texture.weight *= 1 / sum;
  texture.root_weight = texture.weight.sqrt();
  if (!Normalise(texture.weight, texture.root_weight, texture.normalised)) return std::nullopt;
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

std::optional<float> WindowNcc(const cv::Mat1f& gray, int window_px, const WindowWarp& warp,
                               const WindowTexture& reference) {
  if (!CanSampleWindow(gray.size(), window_px, warp)) return std::nullopt;
  return WithSide(window_px, [&](auto side) { return NccOf<side>(gray, warp, reference); });
}

std::optional<ViewNormalEquations> LineariseWindow(const cv::Mat4f& texels, int window_px, const WindowWarp& warp,
                                                   const WindowTexture& reference, bool with_offset) {
  if (!CanSampleWindow(texels.size(), window_px, warp)) return std::nullopt;
  return WithSide(window_px, [&](auto side) { return LineariseOf<side>(texels, warp, reference, with_offset); });
}

}  // namespace rigcal::stereo
