#include "core/mvs/local_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace rigcal::stereo {
namespace {

/// Neighbours are taken from this far around (window sides), and weigh by a Gaussian of half that.
constexpr double kReachInWindows = 1.0;
constexpr int kMinNeighbours = 10;  ///< a quadratic has 6 coefficients
constexpr int kRobustIterations = 4;
/// Scale of the Cauchy weights, pixels: first as wide as neighbours on a steep surface differ, then down to the scatter
/// of good patches.
constexpr double kFirstScalePx = 4, kLastScalePx = 0.5;
constexpr int kPatchesPerTask = 64;

using Coefficients = Eigen::Matrix<double, 6, 1>;

struct Neighbour {
  Coefficients basis;  ///< 1, u, v, u^2, u v, v^2
  double depth_px;
  double weight;
};

std::vector<Neighbour> CollectNeighbours(const StereoScene& scene, const std::vector<SurfacePatch>& patches,
                                         const CellIndex& index, const SurfacePatch& patch, int leave_out) {
  std::vector<Neighbour> neighbours;
  const int view = patch.sightings[0].view;
  const std::optional<Pixel> centre = scene.Project(view, patch.centre_in_world);
  if (!centre) return neighbours;
  const double reach_px = kReachInWindows * scene.options.window_px;
  const int reach = static_cast<int>(std::ceil(reach_px / scene.options.cell_px));
  index.ForNeighbours(view, centre->x_px, reach, [&](int other, float /*depth*/) {
    const SurfacePatch& q = patches[other];
    // A patch that looks the other way is another side of a thin part.
    if (other == leave_out || q.normal_in_world.dot(patch.normal_in_world) < 0) return;
    const std::optional<Pixel> pixel = scene.Project(view, q.centre_in_world);
    if (!pixel) return;
    const Eigen::Vector2d d = pixel->x_px - centre->x_px;
    if (d.squaredNorm() > reach_px * reach_px) return;
    Neighbour n;
    n.basis << 1, d.x(), d.y(), d.x() * d.x(), d.x() * d.y(), d.y() * d.y();
    n.depth_px = scene.views[view].focal_px * (centre->depth / pixel->depth - 1);
    n.weight = std::exp(-2 * d.squaredNorm() / (reach_px * reach_px));
    neighbours.push_back(n);
  });
  return neighbours;
}

/// Slopes of the patch's own plane in the same units.
Eigen::Vector2d OwnSlope(const StereoScene& scene, const SurfacePatch& patch) {
  const int view = patch.sightings[0].view;
  const std::optional<WindowPlane> plane =
      PlaneThrough(scene, view, patch.u_px, patch.v_px, patch.centre_in_world, patch.normal_in_world);
  if (!plane) return Eigen::Vector2d::Zero();
  return plane->inverse_depth.tail<2>() * (scene.views[view].focal_px / plane->inverse_depth[0]);
}

}  // namespace

std::optional<LocalSurface> FitLocalSurface(const StereoScene& scene, const std::vector<SurfacePatch>& patches,
                                            const CellIndex& index, const SurfacePatch& patch, int leave_out) {
  const std::vector<Neighbour> neighbours = CollectNeighbours(scene, patches, index, patch, leave_out);
  if (static_cast<int>(neighbours.size()) < kMinNeighbours) return std::nullopt;
  Coefficients c = Coefficients::Zero();
  c.segment<2>(1) = OwnSlope(scene, patch);
  double scale_px = kFirstScalePx;
  const double shrink = std::pow(kLastScalePx / kFirstScalePx, 1.0 / (kRobustIterations - 1));
  double agreeing = 0;
  for (int iteration = 0; iteration < kRobustIterations; ++iteration, scale_px *= shrink) {
    Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
    Coefficients gradient = Coefficients::Zero();
    agreeing = 0;
    for (const Neighbour& n : neighbours) {
      const double residual = (n.depth_px - c.dot(n.basis)) / scale_px;
      const double robust = 1 / (1 + residual * residual);
      agreeing += robust;
      hessian.selfadjointView<Eigen::Lower>().rankUpdate(n.basis, n.weight * robust);
      gradient += n.weight * robust * n.depth_px * n.basis;
    }
    hessian.diagonal().array() += 1e-9 * hessian(0, 0);  // neighbours on a line leave the rest to this
    c = hessian.selfadjointView<Eigen::Lower>().ldlt().solve(gradient);
    if (!c.allFinite()) return std::nullopt;
  }
  if (agreeing < kMinNeighbours) return std::nullopt;
  LocalSurface surface;
  surface.value_px = c[0];
  surface.slope = c.segment<2>(1);
  surface.curvature_per_px << 2 * c[3], c[4], c[4], 2 * c[5];
  surface.num_neighbours = static_cast<int>(agreeing);
  return surface;
}

bool SmoothPatches(const StereoScene& scene, const Execution& execution, std::vector<SurfacePatch>& patches) {
  const CellIndex index(scene, patches);
  const int count = static_cast<int>(patches.size());
  const int half = scene.options.window_px / 2;
  const double mean_square = half * (half + 1) / 3.0;
  std::vector<SurfacePatch> smooth = patches;
  const bool finished = ParallelFor(execution, (count + kPatchesPerTask - 1) / kPatchesPerTask, [&](int task) {
    for (int i = task * kPatchesPerTask; i < std::min(count, (task + 1) * kPatchesPerTask); ++i) {
      const std::optional<LocalSurface> surface = FitLocalSurface(scene, patches, index, patches[i], -1);
      if (!surface) continue;
      const int view = patches[i].sightings[0].view;
      const StereoView& camera = scene.views[view];
      const std::optional<Pixel> pixel = scene.Project(view, patches[i].centre_in_world);
      const double depth_px = surface->value_px - 0.5 * mean_square * surface->curvature_per_px.trace();
      WindowPlane plane{view, 0, 0, {}};
      const double w = (1 + depth_px / camera.focal_px) / pixel->depth;
      const Eigen::Vector2d by_px = surface->slope / (camera.focal_px * pixel->depth);
      // Referred to pixel (0, 0), where NormalInWorld takes it from.
      plane.inverse_depth << w - by_px.dot(pixel->x_px), by_px;
      if (!(w > 0)) continue;
      smooth[i].centre_in_world = camera.centre_in_world + camera.direction_from_px * pixel->x_px.homogeneous() / w;
      smooth[i].normal_in_world = NormalInWorld(scene, plane);
    }
  });
  patches = std::move(smooth);
  return finished;
}

}  // namespace rigcal::stereo
