#include "sim_fixtures/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <unordered_map>

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kPerTask = 4096;  ///< corners or vertices

/// Samples of a shape at the corners of a regular grid, in those blocks only that may hold surface.
class DistanceGrid {
 public:
  static constexpr int kBlock = 4;  ///< cells along a block's side

  DistanceGrid(const Shape& shape, double cell_m, const Execution& execution)
      : origin_(shape.bounds_in_world.min()), cell_m_(cell_m) {
    const Vector3i num_blocks =
        (shape.bounds_in_world.sizes() / (cell_m * kBlock)).array().ceil().cast<int>().matrix() + Vector3i::Ones();
    corners_ = kBlock * num_blocks + Vector3i::Ones();
    values_.resize(static_cast<std::size_t>(corners_.x()) * corners_.y() * corners_.z());
    FindNearBlocks(shape, num_blocks);
    Sample(shape, execution);
  }

  [[nodiscard]] std::size_t Index(const Vector3i& corner) const {
    return (static_cast<std::size_t>(corner.z()) * corners_.y() + corner.y()) * corners_.x() + corner.x();
  }
  [[nodiscard]] float At(const Vector3i& corner) const { return values_[Index(corner)]; }
  [[nodiscard]] Vector3d Place(const Vector3d& corner) const { return origin_ + cell_m_ * corner; }
  /// The first corner of each block that may hold surface.
  [[nodiscard]] const std::vector<Vector3i>& NearBlocks() const { return near_blocks_; }

 private:
  void FindNearBlocks(const Shape& shape, const Vector3i& num_blocks) {
    // The functions of shape.cpp grow at most this much faster than a true distance (ellipsoids, relief).
    constexpr double kSteepest = 1.6;
    const double reach = kSteepest * cell_m_ * 0.5 * kBlock * std::sqrt(3.0);
    for (int z = 0; z < num_blocks.z(); ++z) {
      for (int y = 0; y < num_blocks.y(); ++y) {
        for (int x = 0; x < num_blocks.x(); ++x) {
          const Vector3i first = kBlock * Vector3i(x, y, z);
          const Vector3d middle = Place(first.cast<double>() + Vector3d::Constant(0.5 * kBlock));
          if (std::abs(shape.distance_m(middle)) < reach) near_blocks_.push_back(first);
        }
      }
    }
  }

  void Sample(const Shape& shape, const Execution& execution) {
    std::vector<bool> listed(values_.size());
    std::vector<Vector3i> wanted;
    for (const Vector3i& first : near_blocks_) {
      for (int i = 0; i < (kBlock + 1) * (kBlock + 1) * (kBlock + 1); ++i) {
        const Vector3i corner =
            first + Vector3i(i % (kBlock + 1), i / (kBlock + 1) % (kBlock + 1), i / ((kBlock + 1) * (kBlock + 1)));
        if (listed[Index(corner)]) continue;
        listed[Index(corner)] = true;
        wanted.push_back(corner);
      }
    }
    ParallelFor(
        execution, static_cast<int>(wanted.size()),
        [&](int i) {
          values_[Index(wanted[i])] = static_cast<float>(shape.distance_m(Place(wanted[i].cast<double>())));
        },
        kPerTask);
  }

  Vector3d origin_;
  double cell_m_;
  Vector3i corners_;
  std::vector<float> values_;
  std::vector<Vector3i> near_blocks_;
};

/// Mean of the places where the cell's twelve edges cross the surface, in grid units; nothing when none does.
std::optional<Vector3d> CrossingInCell(const DistanceGrid& grid, const Vector3i& cell) {
  float value[8];
  int inside = 0;
  for (int i = 0; i < 8; ++i) {
    value[i] = grid.At(cell + Vector3i(i & 1, (i >> 1) & 1, i >> 2));
    inside += value[i] < 0 ? 1 : 0;
  }
  if (inside == 0 || inside == 8) return std::nullopt;
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (int a = 0; a < 8; ++a) {
    for (int bit = 1; bit < 8; bit <<= 1) {
      const int b = a | bit;
      if (b == a || (value[a] < 0) == (value[b] < 0)) continue;
      const double t = value[a] / static_cast<double>(value[a] - value[b]);
      const Vector3d from(a & 1, (a >> 1) & 1, a >> 2), to(b & 1, (b >> 1) & 1, b >> 2);
      sum += from + t * (to - from);
      ++count;
    }
  }
  return cell.cast<double>() + sum / count;
}

Vector3d Gradient(const Shape& shape, const Vector3d& x, double step_m) {
  Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = step_m * Vector3d::Unit(axis);
    gradient[axis] = (shape.distance_m(x + step) - shape.distance_m(x - step)) / (2 * step_m);
  }
  return gradient;
}

/// Moves the vertices onto the surface and gives them their normals.
void Polish(const Shape& shape, double cell_m, TriangleMesh& mesh, const Execution& execution) {
  const int count = static_cast<int>(mesh.vertices_in_world.size());
  mesh.normals_in_world.resize(count, Eigen::Vector3f::UnitZ());
  const auto polish = [&](int i) {
    Vector3d x = mesh.vertices_in_world[i].cast<double>();
    const Vector3d gradient = Gradient(shape, x, 0.5 * cell_m);
    if (!(gradient.squaredNorm() > 0.01)) return;  // the medial axis of a part as thin as a cell
    const Vector3d move = -shape.distance_m(x) / gradient.squaredNorm() * gradient;
    x += move * std::min(1.0, 0.5 * cell_m / std::max(move.norm(), 1e-12));
    mesh.vertices_in_world[i] = x.cast<float>();
    mesh.normals_in_world[i] = gradient.normalized().cast<float>();
  };
  ParallelFor(execution, count, polish, kPerTask);
}

}  // namespace

TriangleMesh MeshOf(const Shape& shape, double cell_m, const Execution& execution) {
  const DistanceGrid grid(shape, cell_m, execution);
  if (execution.Stopped()) return {};
  TriangleMesh mesh;
  std::unordered_map<std::size_t, std::uint32_t> vertex_of_cell;
  const auto for_near_cells = [&](const auto& body) {
    for (const Vector3i& first : grid.NearBlocks()) {
      for (int z = 0; z < DistanceGrid::kBlock; ++z) {
        for (int y = 0; y < DistanceGrid::kBlock; ++y) {
          for (int x = 0; x < DistanceGrid::kBlock; ++x) body(Vector3i(first + Vector3i(x, y, z)));
        }
      }
    }
  };
  for_near_cells([&](const Vector3i& cell) {
    const auto crossing = CrossingInCell(grid, cell);
    if (!crossing) return;
    vertex_of_cell.emplace(grid.Index(cell), static_cast<std::uint32_t>(mesh.vertices_in_world.size()));
    mesh.vertices_in_world.push_back(grid.Place(*crossing).cast<float>());
  });
  for_near_cells([&](const Vector3i& corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool starts_inside = grid.At(corner) < 0;
      if (starts_inside == (grid.At(corner + Vector3i::Unit(axis)) < 0)) continue;
      const Vector3i u = Vector3i::Unit((axis + 1) % 3), v = Vector3i::Unit((axis + 2) % 3);
      std::array<std::uint32_t, 4> around{};
      const std::array<Vector3i, 4> cells = {corner - u - v, corner - v, corner, corner - u};
      bool closed = true;
      for (int i = 0; i < 4; ++i) {
        const auto found =
            (cells[i].array() < 0).any() ? vertex_of_cell.end() : vertex_of_cell.find(grid.Index(cells[i]));
        if (found == vertex_of_cell.end()) {
          closed = false;
        } else {
          around[i] = found->second;
        }
      }
      if (!closed) continue;
      if (!starts_inside) std::swap(around[1], around[3]);
      mesh.triangles.push_back({around[0], around[1], around[2]});
      mesh.triangles.push_back({around[0], around[2], around[3]});
    }
  });
  Polish(shape, cell_m, mesh, execution);
  return mesh;
}

TriangleMesh DiscMesh(double radius_m, double thickness_m) {
  constexpr int kSides = 1440;  // 0.1 m: 0.2 micrometres between chord and circle
  TriangleMesh mesh;
  const auto add = [&](const Vector3d& x, const Vector3d& normal) {
    mesh.vertices_in_world.push_back(x.cast<float>());
    mesh.normals_in_world.push_back(normal.cast<float>());
    return static_cast<std::uint32_t>(mesh.vertices_in_world.size() - 1);
  };
  const std::uint32_t top = add({0, 0, 0}, Vector3d::UnitZ());
  const std::uint32_t bottom = add({0, 0, -thickness_m}, -Vector3d::UnitZ());
  std::vector<std::array<std::uint32_t, 4>> rim;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * std::numbers::pi * side / kSides;
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    const Vector3d high = radius_m * out, low = high - thickness_m * Vector3d::UnitZ();
    rim.push_back({add(high, Vector3d::UnitZ()), add(high, out), add(low, out), add(low, -Vector3d::UnitZ())});
  }
  for (int side = 0; side < kSides; ++side) {
    const auto& a = rim[side];
    const auto& b = rim[(side + 1) % kSides];
    mesh.triangles.push_back({top, a[0], b[0]});
    mesh.triangles.push_back({a[1], a[2], b[2]});
    mesh.triangles.push_back({a[1], b[2], b[1]});
    mesh.triangles.push_back({bottom, b[3], a[3]});
  }
  return mesh;
}

}  // namespace rigcal::sim
