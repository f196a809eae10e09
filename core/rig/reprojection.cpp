#include "core/rig/reprojection.h"

namespace rigcal {

std::optional<Reprojection> Reproject(const Camera& camera, const Rigid3d& cam_from_world,
                                      const Eigen::Vector3d& x_in_world) {
  const Eigen::Matrix3d r = cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d x_in_cam = r * x_in_world + cam_from_world.translation;
  const std::optional<Projection> projection = ProjectWithJacobian(camera, x_in_cam);
  if (!projection) return std::nullopt;
  Reprojection out;
  out.x_px = projection->x_px;
  out.by_intrinsics = projection->by_intrinsics;
  out.by_pose.leftCols<3>().noalias() = -projection->by_point * Skew(x_in_cam);  // d(w x x) = -[x]_x dw
  out.by_pose.rightCols<3>() = projection->by_point;
  out.by_point.noalias() = projection->by_point * r;
  return out;
}

}  // namespace rigcal
