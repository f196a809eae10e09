#pragma once

#include <Eigen/Core>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"

namespace rigcal {

/// How other programs' pixels and axes follow from this program's (pixel (0,0) is the centre of the top-left pixel;
/// camera +x right, +y down, +z forward). Every export that needs one of these takes it from here.

/// Where the origin is the corner of the top-left pixel: x_corner_px = x_px + kCornerOffsetPx. The only place of this
/// constant.
inline constexpr double kCornerOffsetPx = 0.5;

/// (cx, cy) with the origin at the corner of the top-left pixel.
Eigen::Vector2d PrincipalPointFromCornerPx(const Camera& camera);

/// (cx, cy) from the middle of the picture, x right, y down: 0 where the axis goes through the middle. The camera's
/// size is known.
Eigen::Vector2d PrincipalPointFromMiddlePx(const Camera& camera);

/// The principal point, in this program's pixels, of a camera whose axis goes through the middle of its picture.
Eigen::Vector2d MiddlePx(const Camera& camera);

/// The pose of the same camera with the axes of OpenGL: +x right, +y up, +z backward.
Rigid3d GlCamFromWorld(const Rigid3d& cam_from_world);

/// A pose as a matrix, last row 0 0 0 1.
Eigen::Matrix4d MatrixOf(const Rigid3d& b_from_a);

}  // namespace rigcal
