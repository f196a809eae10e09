#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/match/window_texture.h"
#include "core/scene/image_set.h"
#include "core/scene/patch.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// What matching needs of a view, worked out once: pinhole projection into the full-size undistorted picture.
struct ViewGeometry {
  Eigen::Matrix<double, 3, 4> px_from_world;
  Eigen::Vector3d centre_in_world;
  Eigen::Vector3d right_in_world;  ///< the camera's x axis
};

std::vector<ViewGeometry> ViewGeometries(const RigCalibration& calibration);

/// Full-size pixel of a point; nothing when it is not in front of the camera.
std::optional<Eigen::Vector2d> ProjectIntoView(const ViewGeometry& view, const Eigen::Vector3d& x_in_world);

/// The square 3-D patch Q at P (paper section 3.2): its grid of samples in the tangent plane.
struct PatchFrame {
  Eigen::Vector3d centre_in_world;
  int reference_view = 0;
  /// World vectors from one sample to the next at level 0; at level l they are 2^l times as long.
  Eigen::Vector3d step_along_u;
  Eigen::Vector3d step_along_v;
};

/// The frame of a patch: its reference view j0 is the one with the least foreshortening among those that see P inside
/// the picture and the silhouette, u is j0's x axis projected into the tangent plane, and the step is one pixel in the
/// view where the patch's projection has the largest area. Nothing when no view sees P.
std::optional<PatchFrame> FrameOf(const Patch& patch, const std::vector<ViewGeometry>& views, const ImageSet& images);

/// How Q, sized for `level`, lies around the projection of P in a view, in pixels of that level. Exact (a homography),
/// so that the shape's centre is the picture of P and not the mean of the samples. False when a sample is not in front
/// of the camera.
bool ShapeInView(const PatchFrame& frame, const ViewGeometry& view, int level, int side, WindowShape& shape);

}  // namespace rigcal
