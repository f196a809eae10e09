#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "core/geometry/rigid3.h"

namespace rigcal {

/// The order of a camera's intrinsic parameters wherever they stand in one vector (adjustment, covariance).
enum IntrinsicIndex { kFx, kFy, kCx, kCy, kSkew, kK1, kK2, kP1, kP2, kK3, kNumIntrinsics };
using IntrinsicVector = Eigen::Matrix<double, kNumIntrinsics, 1>;
inline constexpr std::array<const char*, kNumIntrinsics> kIntrinsicNames = {"fx", "fy", "cx", "cy", "skew",
                                                                            "k1", "k2", "p1", "p2", "k3"};

/// The intrinsics of one physical camera: a pinhole with Brown distortion in OpenCV's order and meaning.
/// Pixel (0,0) is the centre of the top-left pixel. Camera frame: +x right, +y down, +z forward.
/// With (x, y) = (X/Z, Y/Z), r2 = x^2 + y^2:
///   x_d = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2)
///   y_d = y (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 y^2) + 2 p2 x y
///   u = fx x_d + skew y_d + cx,  v = fy y_d + cy
struct Camera {
  std::string id;
  /// Cameras with the same physical_id are one piece of hardware seen with separate intrinsics (--intrinsics per-view).
  std::string physical_id;
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  double skew_px = 0;  ///< --method paper only; 0 elsewhere
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  [[nodiscard]] bool HasDistortion() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0; }
  [[nodiscard]] Eigen::Matrix3d CalibrationMatrix() const;
  [[nodiscard]] IntrinsicVector Intrinsics() const;
  void SetIntrinsics(const IntrinsicVector& intrinsics);
};

/// The one projection of the program, also differentiated by Ceres. `intrinsics` has kNumIntrinsics entries. The caller
/// makes sure that the point lies in front of the camera.
template <typename T>
void ProjectPoint(const T* intrinsics, const Eigen::Matrix<T, 3, 1>& x_in_cam, T* x_px) {
  const T x = x_in_cam[0] / x_in_cam[2];
  const T y = x_in_cam[1] / x_in_cam[2];
  const T r2 = x * x + y * y;
  const T radial = T(1) + r2 * (intrinsics[kK1] + r2 * (intrinsics[kK2] + r2 * intrinsics[kK3]));
  const T x_d = x * radial + T(2) * intrinsics[kP1] * x * y + intrinsics[kP2] * (r2 + T(2) * x * x);
  const T y_d = y * radial + intrinsics[kP1] * (r2 + T(2) * y * y) + T(2) * intrinsics[kP2] * x * y;
  x_px[0] = intrinsics[kFx] * x_d + intrinsics[kSkew] * y_d + intrinsics[kCx];
  x_px[1] = intrinsics[kFy] * y_d + intrinsics[kCy];
}

/// Pixel of a point in the camera's frame; nothing when it is not in front of the camera.
std::optional<Eigen::Vector2d> Project(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// The same, with d x_px / d x_in_cam (2x3) and d x_px / d intrinsics (2 x kNumIntrinsics).
struct Projection {
  Eigen::Vector2d x_px;
  Eigen::Matrix<double, 2, 3> by_point;
  Eigen::Matrix<double, 2, kNumIntrinsics> by_intrinsics;
};
std::optional<Projection> ProjectWithJacobian(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// Direction (x, y, 1) in the camera's frame that is seen at x_px: the inverse of Project, by Newton's method to 1e-12.
/// Nothing where the distortion polynomial cannot be inverted (beyond the fold of a strong distortion).
std::optional<Eigen::Vector3d> RayInCam(const Camera& camera, const Eigen::Vector2d& x_px);

/// The same camera without distortion: the one of undistorted images.
Camera Undistorted(const Camera& camera);

/// 3x4 projection of an undistorted camera into level l of its pyramid (x_l = x_0 / 2^l; DESIGN.md section 5).
Eigen::Matrix<double, 3, 4> ProjectionMatrix(const Camera& camera, const Rigid3d& cam_from_world, int level);

}  // namespace rigcal
