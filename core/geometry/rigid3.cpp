#include "core/geometry/rigid3.h"

#include <cmath>

namespace rigcal {

Rigid3d Rigid3d::Inverse() const {
  const Eigen::Quaterniond inverse = rotation.conjugate();
  return {inverse, -(inverse * translation)};
}

Eigen::Vector3d operator*(const Rigid3d& b_from_a, const Eigen::Vector3d& x_in_a) {
  return b_from_a.rotation * x_in_a + b_from_a.translation;
}

Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

Eigen::Quaterniond ExpRotation(const Eigen::Vector3d& w_rad) {
  const double angle = w_rad.norm();
  // sin(a/2)/a, by its series below the angle where the next term is under 1e-17.
  const double k = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q(std::cos(0.5 * angle), k * w_rad.x(), k * w_rad.y(), k * w_rad.z());
  q.normalize();
  return q;
}

Eigen::Vector3d LogRotation(const Eigen::Quaterniond& rotation) {
  const Eigen::Quaterniond q =
      rotation.w() < 0 ? Eigen::Quaterniond(-rotation.coeffs()) : rotation;  // q and -q are one rotation: the short way
  const double sine = q.vec().norm();
  const double angle = 2.0 * std::atan2(sine, q.w());
  return sine < 1e-12 ? Eigen::Vector3d(2.0 * q.vec()) : Eigen::Vector3d((angle / sine) * q.vec());
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Rigid3d Disturbed(const Rigid3d& cam_from_world, const Eigen::Matrix<double, 6, 1>& delta) {
  const Eigen::Quaterniond turn = ExpRotation(delta.head<3>());
  return {(turn * cam_from_world.rotation).normalized(), turn * cam_from_world.translation + delta.tail<3>()};
}

Eigen::Vector3d CentreInWorld(const Rigid3d& cam_from_world) {
  return -(cam_from_world.rotation.conjugate() * cam_from_world.translation);
}

}  // namespace rigcal
