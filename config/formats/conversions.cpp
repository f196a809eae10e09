#include "config/formats/conversions.h"

#include "core/base/ensure.h"

namespace rigcal {

Eigen::Vector2d PrincipalPointFromCornerPx(const Camera& camera) {
  return {camera.cx_px + kCornerOffsetPx, camera.cy_px + kCornerOffsetPx};
}

Eigen::Vector2d MiddlePx(const Camera& camera) {
  Ensure(camera.width_px > 0 && camera.height_px > 0, "the middle of a picture needs its size");
  return {0.5 * camera.width_px - kCornerOffsetPx, 0.5 * camera.height_px - kCornerOffsetPx};
}

Eigen::Vector2d PrincipalPointFromMiddlePx(const Camera& camera) {
  return Eigen::Vector2d(camera.cx_px, camera.cy_px) - MiddlePx(camera);
}

Rigid3d GlCamFromWorld(const Rigid3d& cam_from_world) {
  const Eigen::Quaterniond half_turn_about_x(0, 1, 0, 0);  // y and z change their signs
  return Rigid3d{half_turn_about_x, Eigen::Vector3d::Zero()} * cam_from_world;
}

Eigen::Matrix4d MatrixOf(const Rigid3d& b_from_a) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = b_from_a.rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = b_from_a.translation;
  return matrix;
}

}  // namespace rigcal
