#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace rigcal {

/// A rigid motion, always named target_from_source: x_in_b = b_from_a * x_in_a.
struct Rigid3d {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit, Hamilton
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  [[nodiscard]] Rigid3d Inverse() const;
};

Eigen::Vector3d operator*(const Rigid3d& b_from_a, const Eigen::Vector3d& x_in_a);
Rigid3d operator*(const Rigid3d& c_from_b, const Rigid3d& b_from_a);

/// The rotation by |w| radians about w / |w| (Rodrigues), exact also near zero.
Eigen::Quaterniond ExpRotation(const Eigen::Vector3d& w_rad);
/// The inverse of ExpRotation; |result| <= pi.
Eigen::Vector3d LogRotation(const Eigen::Quaterniond& rotation);

/// Skew(a) * b == a x b.
Eigen::Matrix3d Skew(const Eigen::Vector3d& a);

/// How a pose is disturbed, in covariances and in the adjustment: x_in_cam' = Exp(w) * x_in_cam + dt, with
/// delta = (w_rad, dt): about the camera's own axes, in the camera's frame.
Rigid3d Disturbed(const Rigid3d& cam_from_world, const Eigen::Matrix<double, 6, 1>& delta);

/// Position of the camera's centre in the world: -R^T t.
Eigen::Vector3d CentreInWorld(const Rigid3d& cam_from_world);

}  // namespace rigcal
