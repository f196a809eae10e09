#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>

#include "sim_fixtures/mesh.h"

namespace rigcal::sim {

/// Where a ray meets the first surface.
struct SurfacePoint {
  Eigen::Vector3d x_in_world;
  Eigen::Vector3d normal_in_world;  ///< smooth, outward, unit
  int mesh = 0;                     ///< index in the order of the constructor's meshes
};

/// Up to kRayPacket rays from one origin, and what they hit.
inline constexpr int kRayPacket = 16;
struct alignas(64) RayPacket {
  float direction_x[kRayPacket], direction_y[kRayPacket], direction_z[kRayPacket];
  // Results:
  float distance[kRayPacket];  ///< in lengths of the direction
  float normal_x[kRayPacket], normal_y[kRayPacket], normal_z[kRayPacket];
  int mesh[kRayPacket];  ///< kMissed: nothing was hit
};
inline constexpr int kMissed = -1;

/// Meshes that rays can be shot at. Immutable, safe to use from several threads. The only home of Embree.
class RayScene {
 public:
  explicit RayScene(std::vector<TriangleMesh> meshes);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// The first `count` rays of the packet; normals are smooth and not normalised.
  void Shoot(const Eigen::Vector3d& origin_in_world, int count, RayPacket& packet) const;
  [[nodiscard]] std::optional<SurfacePoint> FirstHit(const Eigen::Vector3d& origin_in_world,
                                                     const Eigen::Vector3d& direction_in_world) const;
  /// Whether anything lies strictly between two points, leaving out `margin_m` at either end.
  [[nodiscard]] bool Occluded(const Eigen::Vector3d& from_in_world, const Eigen::Vector3d& to_in_world,
                              double margin_m) const;
  /// The surface point nearest to x_in_world, nothing beyond reach_m.
  [[nodiscard]] std::optional<Eigen::Vector3d> Nearest(const Eigen::Vector3d& x_in_world, double reach_m) const;
  [[nodiscard]] std::span<const TriangleMesh> Meshes() const { return meshes_; }

 private:
  struct Handles;
  std::vector<TriangleMesh> meshes_;
  std::unique_ptr<Handles> handles_;
};

}  // namespace rigcal::sim
