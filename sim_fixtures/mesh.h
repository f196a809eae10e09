#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/execution.h"
#include "sim_fixtures/shape.h"

namespace rigcal::sim {

/// Triangles with outward normals at their corners. Single precision: Embree's, good for 10 nm in a 0.2 m scene.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices_in_world;
  std::vector<Eigen::Vector3f> normals_in_world;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// The surface of a shape: surface nets on a grid of `cell_m`, then every vertex moved onto the surface along its
/// gradient, which also gives the normals. Parts thinner than two cells may
/// be lost. Empty when the execution was stopped.
TriangleMesh MeshOf(const Shape& shape, double cell_m, const Execution& execution);

/// An upright disc from z = -thickness to z = 0 about the axis: the table top.
TriangleMesh DiscMesh(double radius_m, double thickness_m);

}  // namespace rigcal::sim
