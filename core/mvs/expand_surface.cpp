#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/mvs/surface.h"

namespace rigcal::stereo {
namespace {

/// A cell is tried from at most this many neighbours. On templeSparseRing a third try makes 4 % more patches at level
/// 2, 2 % at level 1, and 2 % for 4 % of the time at level 0, where patches abound.
constexpr int kMaxAttemptsPerCell = 3, kMaxAttemptsPerCellAtFullSize = 2;
/// Only views that see the patch less obliquely than this (cosine, 55 degrees) grow it: their cells are small enough on
/// the surface, and the others' cells fill by themselves.
constexpr double kMinCosineToGrow = 0.57;
/// Refinements handed to the threads in one piece: about a millisecond.
constexpr int kCandidatesPerTask = 16;
constexpr int kPatchesPerTask = 64;  ///< the same for the patches whose candidates are listed
constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

/// An empty cell beside a patch, and the patch continued there; nothing when the surface does not go on so.
struct Candidate {
  int view;
  std::size_t cell;
  int parent;
  std::optional<WindowPlane> plane;
  std::vector<Sighting> hints;
  std::vector<CellGrid::CellOfView> seen_at;  ///< where it will be seen besides
};

/// The parent's plane continued to another pixel of one of its views, with the parent's sightings moved along.
void Continue(const StereoScene& scene, const SurfacePatch& parent, const Sighting& in_view,
              const CellGrid::CellPixel& cell, const CellGrid& cells, Candidate& candidate) {
  // The parent lies beside its projection by the offset, and so does what is next to it.
  const Eigen::Vector2d offset_px = in_view.offset_px.cast<double>();
  const StereoView& view = scene.views[in_view.view];
  const Eigen::Vector3d ray =
      view.direction_from_px * Eigen::Vector3d(cell.u_px - offset_px.x(), cell.v_px - offset_px.y(), 1);
  const double along = parent.normal_in_world.dot(ray);
  const double depth = parent.normal_in_world.dot(parent.centre_in_world - view.centre_in_world) / along;
  if (!(depth > 0) || !std::isfinite(depth)) return;
  const Eigen::Vector3d on_plane = view.centre_in_world + depth * ray;
  const Eigen::Vector3d on_ray =
      view.centre_in_world + depth * (view.direction_from_px * Eigen::Vector3d(cell.u_px, cell.v_px, 1));
  candidate.plane = PlaneThrough(scene, in_view.view, cell.u_px, cell.v_px, on_ray, parent.normal_in_world);
  if (!candidate.plane) return;
  const Eigen::Vector3d centre_in_world = CentreInWorld(scene, *candidate.plane);
  for (const Sighting& s : parent.sightings) {
    if (s.view == in_view.view) continue;
    Sighting moved = s;
    if (scene.free_offsets) {
      const std::optional<Pixel> from = scene.Project(s.view, on_plane), to = scene.Project(s.view, on_ray);
      if (!from || !to) continue;
      moved.offset_px += (from->x_px - to->x_px).cast<float>();
    }
    candidate.hints.push_back(moved);
    const std::optional<Pixel> pixel = PixelInImage(scene, centre_in_world, moved);
    if (pixel) candidate.seen_at.push_back({s.view, cells.CellAt(s.view, pixel->x_px)});
  }
}

/// The empty cells beside one patch of the surface that were not tried too often.
std::vector<Candidate> ListCandidates(const StereoScene& scene, const Surface& surface, int parent) {
  const SurfacePatch& patch = surface.patches[parent];
  const CellGrid& cells = surface.cells;
  const int max_attempts = scene.options.level == 0 ? kMaxAttemptsPerCellAtFullSize : kMaxAttemptsPerCell;
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < patch.sightings.size(); ++i) {
    const Sighting& sighting = patch.sightings[i];
    if (patch.normal_in_world.dot(scene.TowardsCamera(sighting.view, patch.centre_in_world)) < kMinCosineToGrow)
      continue;
    for (const auto& [columns, rows] : kNeighbours) {
      const std::optional<CellGrid::CellPixel> cell =
          cells.Neighbour(sighting.view, patch.pixels[i].x_px, columns, rows);
      if (!cell || cells.IsFilled(sighting.view, cell->index)) continue;
      if (cells.Attempts(sighting.view, cell->index) >= max_attempts) continue;
      if (!scene.CanHoldWindow(sighting.view, {cell->u_px, cell->v_px})) continue;
      Candidate& candidate = candidates.emplace_back(Candidate{sighting.view, cell->index, parent, {}, {}, {}});
      Continue(scene, patch, sighting, *cell, cells, candidate);
    }
  }
  return candidates;
}

/// Takes those whose cell nobody has reserved in this round, and marks the cells where they will be seen, so that no
/// other candidate of the round aims at the same place. True when a cell had to be left for the next round.
bool Reserve(const StereoScene& scene, std::vector<Candidate>&& listed, CellGrid& cells,
             std::vector<Candidate>& candidates) {
  const int max_attempts = scene.options.level == 0 ? kMaxAttemptsPerCellAtFullSize : kMaxAttemptsPerCell;
  bool postponed = false;
  for (Candidate& candidate : listed) {
    if (cells.Attempts(candidate.view, candidate.cell) >= max_attempts) continue;
    if (cells.IsPending(candidate.view, candidate.cell)) {
      postponed = true;
      continue;
    }
    if (!candidate.plane) continue;
    cells.CountAttempt(candidate.view, candidate.cell);
    cells.SetPending({candidate.view, candidate.cell});
    for (const CellGrid::CellOfView& cell : candidate.seen_at) cells.SetPending(cell);
    candidates.push_back(std::move(candidate));
  }
  return postponed;
}

}  // namespace

bool ExpandSurface(const StereoScene& scene, std::vector<int> frontier, const Execution& execution, Surface& surface) {
  while (!frontier.empty()) {
    // The best patches choose first.
    std::stable_sort(frontier.begin(), frontier.end(),
                     [&](int a, int b) { return surface.patches[a].ncc > surface.patches[b].ncc; });
    std::vector<std::vector<Candidate>> listed(frontier.size());
    const auto list = [&](int i) { listed[i] = ListCandidates(scene, surface, frontier[i]); };
    if (!ParallelFor(execution, static_cast<int>(frontier.size()), list, kPatchesPerTask)) return false;
    std::vector<Candidate> candidates;
    std::vector<int> next;
    for (std::size_t i = 0; i < frontier.size(); ++i) {
      if (Reserve(scene, std::move(listed[i]), surface.cells, candidates)) next.push_back(frontier[i]);
    }
    surface.cells.ClearPending();
    std::vector<std::optional<SurfacePatch>> grown(candidates.size());
    const auto grow = [&](int i) {
      grown[i] = BuildPatch(scene, *candidates[i].plane, candidates[i].hints);
      // One that left its parent's surface is a start of something else, mostly of nothing.
      if (grown[i] && !AreNeighbours(scene, *grown[i], surface.patches[candidates[i].parent])) grown[i].reset();
    };
    const bool finished = ParallelFor(execution, static_cast<int>(candidates.size()), grow, kCandidatesPerTask);
    if (!finished) return false;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!grown[i] || surface.cells.IsFilled(candidates[i].view, candidates[i].cell)) continue;
      surface.cells.Fill(*grown[i]);
      next.push_back(static_cast<int>(surface.patches.size()));
      surface.patches.push_back(std::move(*grown[i]));
    }
    frontier = std::move(next);
  }
  return true;
}

}  // namespace rigcal::stereo
