#include "core/match/patch_frame.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

/// d pixel (level 0) / d x along a world vector, at a point.
Eigen::Vector2d PixelPerStep(const ViewGeometry& view, const Eigen::Vector3d& x_in_world, const Eigen::Vector3d& step) {
  const Eigen::Vector3d q = view.px_from_world * x_in_world.homogeneous();
  const Eigen::Vector3d dq = view.px_from_world.leftCols<3>() * step;
  return (dq.head<2>() - q.head<2>() * (dq.z() / q.z())) / q.z();
}

}  // namespace

std::vector<ViewGeometry> ViewGeometries(const RigCalibration& calibration) {
  std::vector<ViewGeometry> views;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    const Rigid3d& pose = calibration.views[v].cam_from_world;
    views.push_back({ProjectionMatrix(Undistorted(calibration.CameraOf(v)), pose, 0), CentreInWorld(pose),
                     pose.rotation.conjugate() * Eigen::Vector3d::UnitX()});
  }
  return views;
}

std::optional<Eigen::Vector2d> ProjectIntoView(const ViewGeometry& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d q = view.px_from_world * x_in_world.homogeneous();
  if (!(q.z() > 0)) return std::nullopt;
  return q.head<2>() / q.z();
}

std::optional<PatchFrame> FrameOf(const Patch& patch, const std::vector<ViewGeometry>& views, const ImageSet& images) {
  const Eigen::Vector3d& p = patch.centre_in_world;
  const Eigen::Vector3d n = patch.normal_in_world.normalized();
  PatchFrame frame{p, -1, {}, {}};
  double best_cosine = 0;
  for (const int v : patch.visible_views) {
    const double cosine = n.dot((views[v].centre_in_world - p).normalized());
    const auto x_px = ProjectIntoView(views[v], p);
    if (!(cosine > best_cosine) || !x_px || !images.views[v].IsObject(*x_px)) continue;
    best_cosine = cosine;
    frame.reference_view = v;
  }
  if (frame.reference_view < 0) return std::nullopt;

  const Eigen::Vector3d right = views[frame.reference_view].right_in_world;
  Eigen::Vector3d u = right - n * n.dot(right);
  if (!(u.squaredNorm() > 0)) return std::nullopt;  // the normal is the camera's x axis: seen edge on
  u.normalize();
  const Eigen::Vector3d v_axis = n.cross(u);
  double largest_px2 = 0;  // area of the unit square's projection
  for (const int v : patch.visible_views) {
    if (!ProjectIntoView(views[v], p)) continue;
    Eigen::Matrix2d px_from_plane;
    px_from_plane << PixelPerStep(views[v], p, u), PixelPerStep(views[v], p, v_axis);
    largest_px2 = std::max(largest_px2, std::abs(px_from_plane.determinant()));
  }
  if (!(largest_px2 > 0)) return std::nullopt;
  const double step = 1 / std::sqrt(largest_px2);
  frame.step_along_u = step * u;
  frame.step_along_v = step * v_axis;
  return frame;
}

bool ShapeInView(const PatchFrame& frame, const ViewGeometry& view, int level, int side, WindowShape& shape) {
  Ensure(side % 2 == 1 && side <= kMaxWindowPx, "a matching window has an odd side of at most 19 samples");
  const double scale = std::ldexp(1.0, level);
  const Eigen::Vector3d centre = view.px_from_world * frame.centre_in_world.homogeneous();
  const Eigen::Vector3d along_u = view.px_from_world.leftCols<3>() * (scale * frame.step_along_u);
  const Eigen::Vector3d along_v = view.px_from_world.leftCols<3>() * (scale * frame.step_along_v);
  const Eigen::Vector2d centre_px = centre.head<2>() / centre.z();
  const int half = side / 2;
  shape.side = side;
  int k = 0;
  for (int j = -half; j <= half; ++j) {
    for (int i = -half; i <= half; ++i, ++k) {
      const Eigen::Vector3d q = centre + i * along_u + j * along_v;
      if (!(q.z() > 0)) return false;
      shape.dx_px[k] = static_cast<float>((q.x() / q.z() - centre_px.x()) / scale);
      shape.dy_px[k] = static_cast<float>((q.y() / q.z() - centre_px.y()) / scale);
    }
  }
  const auto [min_x, max_x] = std::minmax_element(shape.dx_px.begin(), shape.dx_px.begin() + k);
  const auto [min_y, max_y] = std::minmax_element(shape.dy_px.begin(), shape.dy_px.begin() + k);
  shape.min_dx_px = *min_x, shape.max_dx_px = *max_x;
  shape.min_dy_px = *min_y, shape.max_dy_px = *max_y;
  shape.px_from_step << PixelPerStep(view, frame.centre_in_world, frame.step_along_u),
      PixelPerStep(view, frame.centre_in_world, frame.step_along_v);
  return shape.px_from_step.allFinite() && std::abs(shape.px_from_step.determinant()) > 0;
}

}  // namespace rigcal
