#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace rigcal {

/// The point whose projections by 3x4 matrices lie nearest to the given pixels: the linear solution, then Gauss-Newton
/// on the reprojection error. Both spans have the same length >= 2. Nothing when the rays are (nearly) parallel or when
/// the point ends behind a camera. Robust against nothing: outliers are the caller's affair.
std::optional<Eigen::Vector3d> TriangulateInWorld(std::span<const Eigen::Matrix<double, 3, 4>> px_from_world,
                                                  std::span<const Eigen::Vector2d> x_px);

}  // namespace rigcal
