#include "core/geometry/camera.h"

#include <cmath>

namespace rigcal {
namespace {

/// Distorted normalised coordinates and their 2x2 derivative by the undistorted ones.
Eigen::Vector2d Distort(const Camera& c, const Eigen::Vector2d& n, Eigen::Matrix2d* by_n) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double radial_by_r2 = c.k1 + r2 * (2 * c.k2 + 3 * r2 * c.k3);
  if (by_n != nullptr) {
    const double cross = 2 * x * y * radial_by_r2 + 2 * c.p1 * x + 2 * c.p2 * y;
    (*by_n) << radial + 2 * x * x * radial_by_r2 + 2 * c.p1 * y + 6 * c.p2 * x, cross, cross,
        radial + 2 * y * y * radial_by_r2 + 6 * c.p1 * y + 2 * c.p2 * x;
  }
  return {x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x),
          y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y};
}

}  // namespace

Eigen::Matrix3d Camera::CalibrationMatrix() const {
  Eigen::Matrix3d k;
  k << fx_px, skew_px, cx_px, 0, fy_px, cy_px, 0, 0, 1;
  return k;
}

IntrinsicVector Camera::Intrinsics() const {
  IntrinsicVector v;
  v << fx_px, fy_px, cx_px, cy_px, skew_px, k1, k2, p1, p2, k3;
  return v;
}

void Camera::SetIntrinsics(const IntrinsicVector& v) {
  fx_px = v[kFx], fy_px = v[kFy], cx_px = v[kCx], cy_px = v[kCy], skew_px = v[kSkew];
  k1 = v[kK1], k2 = v[kK2], p1 = v[kP1], p2 = v[kP2], k3 = v[kK3];
}

std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  const IntrinsicVector intrinsics = camera.Intrinsics();
  Eigen::Vector2d x_px;
  ProjectPoint(intrinsics.data(), x_in_cam, x_px.data());
  return x_px;
}

std::optional<Projection> ProjectWithJacobian(const Camera& c, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0)) return std::nullopt;
  const double inv_z = 1 / x_in_cam.z();
  const Eigen::Vector2d n = x_in_cam.head<2>() * inv_z;
  Eigen::Matrix2d d_by_n;
  const Eigen::Vector2d d = Distort(c, n, &d_by_n);
  Eigen::Matrix<double, 2, 3> n_by_point;
  n_by_point << inv_z, 0, -n.x() * inv_z, 0, inv_z, -n.y() * inv_z;
  Eigen::Matrix2d px_by_d;
  px_by_d << c.fx_px, c.skew_px, 0, c.fy_px;

  Projection out;
  out.x_px = px_by_d * d + Eigen::Vector2d(c.cx_px, c.cy_px);
  out.by_point = px_by_d * d_by_n * n_by_point;
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  Eigen::Matrix<double, 2, 5> d_by_k;
  d_by_k << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, x * r2 * r2 * r2,  //
      y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y, y * r2 * r2 * r2;
  out.by_intrinsics.setZero();
  out.by_intrinsics(0, kFx) = d.x();
  out.by_intrinsics(1, kFy) = d.y();
  out.by_intrinsics(0, kCx) = 1;
  out.by_intrinsics(1, kCy) = 1;
  out.by_intrinsics(0, kSkew) = d.y();
  out.by_intrinsics.block<2, 5>(0, kK1) = px_by_d * d_by_k;
  return out;
}

std::optional<Eigen::Vector3d> RayInCam(const Camera& c, const Eigen::Vector2d& x_px) {
  const double y_d = (x_px.y() - c.cy_px) / c.fy_px;
  const Eigen::Vector2d d((x_px.x() - c.cx_px - c.skew_px * y_d) / c.fx_px, y_d);
  if (!c.HasDistortion()) return Eigen::Vector3d(d.x(), d.y(), 1);
  constexpr int kMaxIterations = 30;
  constexpr double kTolerance = 1e-12;  // normalised units: 1e-8 px at any focal length in use
  Eigen::Vector2d n = d;
  for (int i = 0; i < kMaxIterations; ++i) {
    Eigen::Matrix2d by_n;
    const Eigen::Vector2d error = Distort(c, n, &by_n) - d;
    if (error.norm() < kTolerance) return Eigen::Vector3d(n.x(), n.y(), 1);
    if (!(by_n.determinant() > 0)) return std::nullopt;
    n -= by_n.inverse() * error;
    if (!n.allFinite()) return std::nullopt;
  }
  return std::nullopt;
}

Camera Undistorted(const Camera& camera) {
  Camera pinhole = camera;
  pinhole.k1 = pinhole.k2 = pinhole.p1 = pinhole.p2 = pinhole.k3 = 0;
  return pinhole;
}

Eigen::Matrix<double, 3, 4> ProjectionMatrix(const Camera& camera, const Rigid3d& cam_from_world, int level) {
  Eigen::Matrix<double, 3, 4> p;
  p << cam_from_world.rotation.toRotationMatrix(), cam_from_world.translation;
  p = camera.CalibrationMatrix() * p;
  p.topRows<2>() *= std::ldexp(1.0, -level);
  return p;
}

}  // namespace rigcal
