#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/mvs/reconstruct.h"

namespace rigcal::stereo {

/// One view at the reconstructed level. All pixels of this stage are pixels of that level (x_L = x_0 / 2^L).
struct StereoView {
  /// Grey value, its derivatives by x and y (differences), and 1 where only the object is seen (else 0):
  /// together, because one position needs them all.
  cv::Mat4f texels;
  cv::Mat1f gray;                         ///< the grey values of texels alone, a quarter of the memory to go through
  const ViewImages* full_size = nullptr;  ///< for the silhouette; owned by the caller of Reconstruct
  Eigen::Matrix<double, 3, 4> px_from_world;
  Eigen::Matrix3d direction_from_px;  ///< world direction with depth 1 of a homogeneous pixel
  Eigen::Vector3d centre_in_world;
  double focal_px = 0;
  double error_px = 0;  ///< how far this view's projections may be off
};

/// x_j ~ infinite_homography * (u, v, 1) + w * epipole: where the point at inverse depth w behind pixel (u, v) of view
/// r is seen in view j. On a plane w is an affine function of (u, v), which makes the plane's homography linear in the
/// three numbers of WindowPlane.
struct PairGeometry {
  Eigen::Matrix3d infinite_homography;
  Eigen::Vector3d epipole;
};

struct Pixel {
  Eigen::Vector2d x_px;
  double depth;
};

/// What every step of the stage reads and none changes.
struct StereoScene {
  StereoOptions options;
  std::vector<StereoView> views;
  std::vector<PairGeometry> pairs;  ///< [r * NumViews() + j]
  /// Whether the cameras are so far off that every view's texture may lie beside the projection of its patch; then each
  /// view has a free offset with a prior of its error_px.
  bool free_offsets = false;

  [[nodiscard]] int NumViews() const { return static_cast<int>(views.size()); }
  [[nodiscard]] const PairGeometry& Pair(int r, int j) const { return pairs[r * NumViews() + j]; }
  /// Pixel of the level and depth; nothing behind the camera.
  [[nodiscard]] std::optional<Pixel> Project(int view, const Eigen::Vector3d& x_in_world) const;
  /// Unit vector from a point to the camera.
  [[nodiscard]] Eigen::Vector3d TowardsCamera(int view, const Eigen::Vector3d& x_in_world) const;
  /// Length in the world that is one pixel of the level wide at `depth`.
  [[nodiscard]] double FootprintInWorld(int view, double depth) const { return depth / views[view].focal_px; }
  /// Whether a pixel of the level lies in the image with room for a window, and on the object.
  [[nodiscard]] bool CanHoldWindow(int view, const Eigen::Vector2d& x_px) const;
};

/// Nothing when it was stopped.
std::optional<StereoScene> MakeStereoScene(const ImageSet& images, const RigCalibration& calibration,
                                           const StereoOptions& options, const Execution& execution);

}  // namespace rigcal::stereo
