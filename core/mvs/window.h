#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mvs/stereo_scene.h"

namespace rigcal::stereo {

/// A plane as its reference view sees it: inverse depth at the window's centre pixel, and its change per pixel to the
/// right and down. The window is the block of pixels around (u_px, v_px), so the reference needs no interpolation.
struct WindowPlane {
  int reference_view = 0;
  int u_px = 0;
  int v_px = 0;
  Eigen::Vector3d inverse_depth = Eigen::Vector3d::Zero();  ///< w, dw/du, dw/dv
};

/// The plane through a point with a normal, seen at a pixel of the reference view; nothing when it lies behind the
/// camera or is seen from its edge or its back.
std::optional<WindowPlane> PlaneThrough(const StereoScene& scene, int reference_view, int u_px, int v_px,
                                        const Eigen::Vector3d& point_in_world, const Eigen::Vector3d& normal_in_world);
Eigen::Vector3d CentreInWorld(const StereoScene& scene, const WindowPlane& plane);
/// Unit, towards the reference camera.
Eigen::Vector3d NormalInWorld(const StereoScene& scene, const WindowPlane& plane);

/// A window whose grey values vary less than a quarter of an 8-bit step (rms) shows nothing but rounding.
inline constexpr float kMinWindowContrast = 0.25f / 255;

/// Windows are stored in whole vectors of 8 samples; what is beyond side * side has weight 0.
constexpr int PaddedSamples(int side) {
  return (side * side + 7) / 8 * 8;
}
inline constexpr int kMaxWindowSamples = PaddedSamples(kMaxStereoWindowPx);
using WindowSamples = Eigen::Array<float, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxWindowSamples, 1>;

/// A window's grey values, row by row, weighed: less towards its edge, so that what is around the centre decides on a
/// curved surface, and nothing off the object. All have PaddedSamples(side) entries.
struct WindowTexture {
  WindowSamples weight;       ///< sum 1
  WindowSamples root_weight;  ///< square roots
  WindowSamples normalised;   ///< root_weight * (value - weighted mean) / norm: sum of squares 1
};

/// The window's texture in its reference view; nothing when it leaves the image or shows nothing at all.
std::optional<WindowTexture> ReferenceTexture(const StereoScene& scene, const WindowPlane& plane);

/// The window's homography into another view, about the window's centre: x = (c + cu du + cv dv) dehomogenised +
/// offset.
struct WindowWarp {
  Eigen::Vector3f centre, by_u, by_v;  ///< scaled so that centre.z == 1
  Eigen::Vector3f epipole;             ///< same scale; d(numerators) / dw
  Eigen::Vector2f offset_px;

  [[nodiscard]] Eigen::Vector2f CentrePx() const { return centre.head<2>() + offset_px; }
  /// d pixel of the view / d pixel of the reference, at the centre.
  [[nodiscard]] Eigen::Matrix2f PxByReferencePx() const {
    Eigen::Matrix2f by;
    by << by_u.head<2>() - centre.head<2>() * by_u.z(), by_v.head<2>() - centre.head<2>() * by_v.z();
    return by;
  }
  /// How many pixels of the view the window's centre moves per unit of inverse depth.
  [[nodiscard]] Eigen::Vector2f CentreByInverseDepth() const {
    return epipole.head<2>() - centre.head<2>() * epipole.z();
  }
};

/// Nothing when the window's centre lies behind the view, or the view shows the window smaller or larger than
/// kMaxScale allows.
std::optional<WindowWarp> MakeWarp(const StereoScene& scene, const WindowPlane& plane, int view,
                                   const Eigen::Vector2f& offset_px);

/// NCC of a view with the reference, bilinear; nothing when the window leaves the image.
std::optional<float> WindowNcc(const cv::Mat1f& gray, int window_px, const WindowWarp& warp,
                               const WindowTexture& reference);

/// One view's share of the least-squares problem min sum_j |f_j - f_r|^2 over normalised textures
/// (|f_j - f_r|^2 = 2 - 2 NCC). Parameters: w, dw/du, dw/dv, and the view's offset x, y.
struct ViewNormalEquations {
  float ncc = 0;
  Eigen::Matrix<double, 5, 5> hessian;
  Eigen::Matrix<double, 5, 1> gradient;
};

/// Nothing when the window leaves the image or shows nothing.
/// Without `with_offset` the offset's rows stay zero.
std::optional<ViewNormalEquations> LineariseWindow(const cv::Mat4f& texels, int window_px, const WindowWarp& warp,
                                                   const WindowTexture& reference, bool with_offset);

/// The best place of the window within +-radius_px (of the reference) of the warp's own place, in whole pixels of the
/// reference, by NCC. Near the image's edge the radius is what fits; nothing when the window itself leaves the image.
struct OffsetMatch {
  Eigen::Vector2f offset_px;  ///< the warp's own included
  float ncc;
};
inline constexpr int kMaxSearchRadiusPx = 8;
std::optional<OffsetMatch> SearchOffset(const cv::Mat1f& gray, int window_px, const WindowWarp& warp,
                                        const WindowTexture& reference, int radius_px);

}  // namespace rigcal::stereo
