#include "core/mvs/local_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/mvs/surface.h"

namespace rigcal::stereo {
namespace {

/// Neighbours are taken from this far around (window sides), and weigh less with the square of the distance, down to
/// kWeightAtReach there (a Gaussian does as well on the plaster set, 1.93 against 1.91 % far off, and costs an
/// exponential). Overlapping windows share their noise: where there is much of it, only neighbours from farther
/// away take it out. On 400 x 300 pixels the plaster's patches then lie 0.36 px off instead of 0.44 px, 1.9 % instead
/// of 3.2 % of them more than 2 px.
constexpr double kReachInWindows = 1.0, kFarReachInWindows = 2.0;
constexpr float kWeightAtReach = 0.1f;
/// SurfacePatch::sigma_px from which that is done: at 0.05 the textured set stays at 0.08 px, without a limit 0.09 px.
constexpr float kNoisyPx = 0.05f;
constexpr int kMinNeighbours = 10;  ///< a quadratic has 6 coefficients
/// Neighbours around a noisy patch that agree with it, for each pixel of its sigma: with fewer it stays as far off as
/// it is. On the plaster set 2 % of the patches go, and every fifth of those more than 2 px off.
constexpr float kMinNeighboursPerPx = 120;
constexpr int kRobustIterations = 4;
/// Scale of the Cauchy weights, pixels: first as wide as neighbours on a steep surface differ, then down to the scatter
/// of good patches.
constexpr double kFirstScalePx = 4, kLastScalePx = 0.5;
constexpr int kPatchesPerTask = 64;
constexpr int kNone = -1;  ///< no patch is left out

using Coefficients = Eigen::Matrix<double, 6, 1>;

/// The quadratic's basis is 1, u, v, u^2, u v, v^2; products of two of them are the 15 monomials up to degree 4, which
/// are summed instead of the 6 x 6 products: kMoment[i][j] is the monomial basis[i] * basis[j].
constexpr int kMoment[6][6] = {{0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
                               {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14}};

/// Coordinates are in units of the reach, so that single precision carries the fourth powers.
struct Neighbour {
  Eigen::Array<float, 16, 1> monomials;  ///< those of kMoment, then a zero
  float depth_px;
  float weight;
};

Neighbour MakeNeighbour(const Eigen::Vector2f& d, float depth_px) {
  const float u = d.x(), v = d.y(), uu = u * u, uv = u * v, vv = v * v;
  Neighbour n;
  n.monomials << 1, u, v, uu, uv, vv, uu * u, uu * v, u * vv, vv * v, uu * uu, uu * uv, uu * vv, uv * vv, vv * vv, 0;
  n.depth_px = depth_px;
  n.weight = 1 - (1 - kWeightAtReach) * (uu + vv);
  return n;
}

std::vector<Neighbour> CollectNeighbours(const StereoScene& scene, const CellIndex& index, const SurfacePatch& patch,
                                         int leave_out, double reach_px) {
  std::vector<Neighbour> neighbours;
  const int view = patch.sightings[0].view;
  const Pixel& seen = patch.pixels[0];
  const Eigen::Vector2d centre_px = seen.x_px - patch.sightings[0].offset_px.cast<double>();
  const int reach = static_cast<int>(std::ceil(reach_px / scene.options.cell_px));
  neighbours.reserve(static_cast<std::size_t>((2 * reach + 1) * (2 * reach + 1)));
  const Eigen::Vector3f normal_in_world = patch.normal_in_world.cast<float>();
  const float focal_px = static_cast<float>(scene.views[view].focal_px), depth = static_cast<float>(seen.depth);
  index.ForNeighbours(view, centre_px, reach, [&](const CellIndex::Entry& other) {
    const Eigen::Vector2f d = (other.centre_px - centre_px.cast<float>()) / static_cast<float>(reach_px);
    if (other.patch == leave_out || d.squaredNorm() > 1) return;
    // A patch that looks the other way is another side of a thin part.
    if (other.normal_in_world.dot(normal_in_world) < 0) return;
    neighbours.push_back(MakeNeighbour(d, focal_px * (depth - other.depth) / other.depth));
  });
  return neighbours;
}

/// One step of iteratively reweighted least squares with Cauchy weights. Returns their sum, the number of neighbours
/// that agree with `c`.
float Reweigh(const std::vector<Neighbour>& neighbours, float scale_px, Coefficients& c) {
  Eigen::Array<float, 16, 1> moments = Eigen::Array<float, 16, 1>::Zero();
  Eigen::Array<float, 8, 1> right = Eigen::Array<float, 8, 1>::Zero(), at = Eigen::Array<float, 8, 1>::Zero();
  at.head<6>() = c.cast<float>().array();
  float agreeing = 0;
  for (const Neighbour& n : neighbours) {
    const float residual = (n.depth_px - (at * n.monomials.head<8>()).sum()) / scale_px;
    const float robust = 1 / (1 + residual * residual);
    agreeing += robust;
    moments += n.weight * robust * n.monomials;
    right += n.weight * robust * n.depth_px * n.monomials.head<8>();
  }
  Eigen::Matrix<double, 6, 6> hessian;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) hessian(i, j) = static_cast<double>(moments[kMoment[i][j]]);
  }
  constexpr double kTinyShare = 1e-6;  // neighbours on a line leave the rest to this
  hessian.diagonal().array() += kTinyShare * hessian(0, 0);
  c = hessian.ldlt().solve(right.head<6>().matrix().cast<double>());
  return agreeing;
}

/// Slopes of the patch's own plane in the same units.
Eigen::Vector2d OwnSlope(const StereoScene& scene, const SurfacePatch& patch) {
  const int view = patch.sightings[0].view;
  const std::optional<WindowPlane> plane =
      PlaneThrough(scene, view, patch.u_px, patch.v_px, patch.centre_in_world, patch.normal_in_world);
  if (!plane) return Eigen::Vector2d::Zero();
  return plane->inverse_depth.tail<2>() * (scene.views[view].focal_px / plane->inverse_depth[0]);
}

std::optional<LocalSurface> FitSurface(const StereoScene& scene, const CellIndex& index, const SurfacePatch& patch,
                                       int leave_out, double reach_in_windows) {
  const double reach_px = reach_in_windows * scene.options.window_px;
  const std::vector<Neighbour> neighbours = CollectNeighbours(scene, index, patch, leave_out, reach_px);
  if (static_cast<int>(neighbours.size()) < kMinNeighbours) return std::nullopt;
  Coefficients c = Coefficients::Zero();
  c.segment<2>(1) = reach_px * OwnSlope(scene, patch);
  double scale_px = kFirstScalePx;
  const double shrink = std::pow(kLastScalePx / kFirstScalePx, 1.0 / (kRobustIterations - 1));
  float agreeing = 0;
  for (int iteration = 0; iteration < kRobustIterations; ++iteration, scale_px *= shrink) {
    agreeing = Reweigh(neighbours, static_cast<float>(scale_px), c);
    if (!c.allFinite()) return std::nullopt;
  }
  if (agreeing < kMinNeighbours) return std::nullopt;
  LocalSurface surface;
  surface.value_px = c[0];
  surface.slope = c.segment<2>(1) / reach_px;
  surface.curvature_per_px << 2 * c[3], c[4], c[4], 2 * c[5];
  surface.curvature_per_px /= reach_px * reach_px;
  surface.num_neighbours = static_cast<int>(agreeing);
  return surface;
}

struct Place {
  Eigen::Vector3d centre_in_world, normal_in_world;
};

/// What becomes of a patch: it goes, it moves, or (without a place) it stays.
struct Smoothed {
  bool is_lost = false;
  std::optional<Place> place;
};

/// Where the surface lies at the patch, less what a flat window gets wrong (SmoothPatches).
std::optional<Place> PlaceOn(const StereoScene& scene, const LocalSurface& surface, const SurfacePatch& patch) {
  const int half = scene.options.window_px / 2;
  const double mean_square = half * (half + 1) / 3.0;
  const int view = patch.sightings[0].view;
  const StereoView& camera = scene.views[view];
  const std::optional<Pixel> pixel = scene.Project(view, patch.centre_in_world);
  const double depth_px = surface.value_px - 0.5 * mean_square * surface.curvature_per_px.trace();
  const double w = (1 + depth_px / camera.focal_px) / pixel->depth;
  if (!(w > 0)) return std::nullopt;
  const Eigen::Vector2d by_px = surface.slope / (camera.focal_px * pixel->depth);
  WindowPlane plane{view, 0, 0, {}};
  // Referred to pixel (0, 0), where NormalInWorld takes it from.
  plane.inverse_depth << w - by_px.dot(pixel->x_px), by_px;
  return Place{camera.centre_in_world + camera.direction_from_px * pixel->x_px.homogeneous() / w,
               NormalInWorld(scene, plane)};
}

Smoothed Smooth(const StereoScene& scene, const CellIndex& index, const SurfacePatch& patch) {
  std::optional<LocalSurface> surface;
  if (patch.sigma_px >= kNoisyPx) {
    surface = FitSurface(scene, index, patch, kNone, kFarReachInWindows);
    const int agreeing = surface ? surface->num_neighbours : 0;
    // With free offsets sigma_px is the cameras' error, which neighbours share.
    if (!scene.free_offsets && static_cast<float>(agreeing) < kMinNeighboursPerPx * patch.sigma_px) return {true, {}};
  }
  if (!surface) surface = FitSurface(scene, index, patch, kNone, kReachInWindows);
  return {false, surface ? PlaceOn(scene, *surface, patch) : std::nullopt};
}

}  // namespace

std::optional<LocalSurface> FitLocalSurface(const StereoScene& scene, const std::vector<SurfacePatch>& patches,
                                            const CellIndex& index, int patch) {
  return FitSurface(scene, index, patches[patch], patch, kReachInWindows);
}

bool SmoothPatches(const StereoScene& scene, const Execution& execution, std::vector<SurfacePatch>& patches) {
  const CellIndex index(scene, patches, execution);
  std::vector<Smoothed> smoothed(patches.size());
  const bool finished = ParallelFor(
      execution, static_cast<int>(patches.size()), [&](int i) { smoothed[i] = Smooth(scene, index, patches[i]); },
      kPatchesPerTask);
  std::vector<char> kept(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    kept[i] = !smoothed[i].is_lost;
    if (const std::optional<Place>& place = smoothed[i].place) {
      patches[i].centre_in_world = place->centre_in_world;
      patches[i].normal_in_world = place->normal_in_world;
    }
  }
  KeepMarked(kept, patches);
  return finished;
}

}  // namespace rigcal::stereo
