#include "core/geometry/triangulate.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/base/ensure.h"

namespace rigcal {

std::optional<Eigen::Vector3d> TriangulateInWorld(std::span<const Eigen::Matrix<double, 3, 4>> px_from_world,
                                                  std::span<const Eigen::Vector2d> x_px) {
  Ensure(px_from_world.size() == x_px.size() && x_px.size() >= 2, "triangulation needs one pixel per view, two views");
  const std::size_t n = x_px.size();
  Eigen::Matrix4d ata = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& p = px_from_world[i];
    for (int row = 0; row < 2; ++row) {
      Eigen::RowVector4d a = x_px[i][row] * p.row(2) - p.row(row);
      a /= a.head<3>().norm();
      ata += a.transpose() * a;
    }
  }
  // A x = 0 with x = (X, 1): the normal equations of the upper left block. Their condition tells parallel rays.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(ata.topLeftCorner<3, 3>());
  constexpr double kMinConditionInverse = 1e-10;  // rays within about 1e-5 rad of each other
  if (!(spectrum.eigenvalues()[0] > kMinConditionInverse * spectrum.eigenvalues()[2])) return std::nullopt;
  Eigen::Vector3d x = -(ata.topLeftCorner<3, 3>().ldlt().solve(ata.topRightCorner<3, 1>()));

  constexpr int kIterations = 4;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d q = px_from_world[i] * x.homogeneous();
      if (!(q.z() > 0)) return std::nullopt;
      const Eigen::Vector2d projected = q.head<2>() / q.z();
      Eigen::Matrix<double, 2, 3> j = px_from_world[i].topLeftCorner<2, 3>();
      j -= projected * px_from_world[i].block<1, 3>(2, 0);
      j /= q.z();
      h += j.transpose() * j;
      g += j.transpose() * (projected - x_px[i]);
    }
    x -= h.ldlt().solve(g);
    if (!x.allFinite()) return std::nullopt;
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!(px_from_world[i].row(2).dot(x.homogeneous()) > 0)) return std::nullopt;
  }
  return x;
}

}  // namespace rigcal
