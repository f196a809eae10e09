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
constexpr std::array<std::array<int, 2>, 4> kNeighbours = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

struct Candidate {
  WindowPlane plane;
  std::vector<Sighting> hints;
  std::size_t cell;
  int parent;
};

/// The parent's plane continued to another pixel of one of its views, with the parent's sightings moved along.
std::optional<Candidate> Continue(const StereoScene& scene, const SurfacePatch& parent, const Sighting& in_view,
                                  const CellGrid::CellPixel& cell) {
  // The parent lies beside its projection by the offset, and so does what is next to it.
  const Eigen::Vector2d offset_px = in_view.offset_px.cast<double>();
  const StereoView& view = scene.views[in_view.view];
  const Eigen::Vector3d ray =
      view.direction_from_px * Eigen::Vector3d(cell.u_px - offset_px.x(), cell.v_px - offset_px.y(), 1);
  const double along = parent.normal_in_world.dot(ray);
  const double depth = parent.normal_in_world.dot(parent.centre_in_world - view.centre_in_world) / along;
  if (!(depth > 0) || !std::isfinite(depth)) return std::nullopt;
  const Eigen::Vector3d on_plane = view.centre_in_world + depth * ray;
  const Eigen::Vector3d on_ray =
      view.centre_in_world + depth * (view.direction_from_px * Eigen::Vector3d(cell.u_px, cell.v_px, 1));
  const std::optional<WindowPlane> plane =
      PlaneThrough(scene, in_view.view, cell.u_px, cell.v_px, on_ray, parent.normal_in_world);
  if (!plane) return std::nullopt;
  Candidate candidate{*plane, {}, cell.index, -1};
  for (const Sighting& s : parent.sightings) {
    if (s.view == in_view.view) continue;
    Sighting moved = s;
    if (scene.free_offsets) {
      const std::optional<Pixel> from = scene.Project(s.view, on_plane), to = scene.Project(s.view, on_ray);
      if (!from || !to) continue;
      moved.offset_px += (from->x_px - to->x_px).cast<float>();
    }
    candidate.hints.push_back(moved);
  }
  return candidate;
}

/// Marks the cells where the candidate will be seen, so that no other candidate of this round aims at the same place.
void Reserve(const StereoScene& scene, const Candidate& candidate, CellGrid& cells) {
  const int reference = candidate.plane.reference_view;
  cells.SetPending(reference, candidate.cell);
  cells.CountAttempt(reference, candidate.cell);
  const Eigen::Vector3d centre_in_world = CentreInWorld(scene, candidate.plane);
  for (const Sighting& s : candidate.hints) {
    const std::optional<Pixel> pixel = PixelInImage(scene, centre_in_world, s);
    if (pixel) cells.SetPending(s.view, cells.CellAt(s.view, pixel->x_px));
  }
}

/// Candidates beside one patch; true when a cell had to be left for the next round.
bool ListCandidates(const StereoScene& scene, const std::vector<SurfacePatch>& patches, int parent, CellGrid& cells,
                    std::vector<Candidate>& candidates) {
  const SurfacePatch& patch = patches[parent];
  const int max_attempts = scene.options.level == 0 ? kMaxAttemptsPerCellAtFullSize : kMaxAttemptsPerCell;
  bool postponed = false;
  for (std::size_t i = 0; i < patch.sightings.size(); ++i) {
    const Sighting& sighting = patch.sightings[i];
    if (patch.normal_in_world.dot(scene.TowardsCamera(sighting.view, patch.centre_in_world)) < kMinCosineToGrow)
      continue;
    for (const auto& [columns, rows] : kNeighbours) {
      const std::optional<CellGrid::CellPixel> cell =
          cells.Neighbour(sighting.view, patch.pixels[i].x_px, columns, rows);
      if (!cell || cells.IsFilled(sighting.view, cell->index) || cells.IsBarred(sighting.view, cell->index)) continue;
      if (cells.Attempts(sighting.view, cell->index) >= max_attempts) continue;
      if (!scene.CanHoldWindow(sighting.view, {cell->u_px, cell->v_px})) {
        cells.Bar(sighting.view, cell->index);
        continue;
      }
      if (cells.IsPending(sighting.view, cell->index)) {
        postponed = true;
        continue;
      }
      std::optional<Candidate> candidate = Continue(scene, patch, sighting, *cell);
      if (!candidate) continue;
      candidate->parent = parent;
      Reserve(scene, *candidate, cells);
      candidates.push_back(std::move(*candidate));
    }
  }
  return postponed;
}

}  // namespace

bool ExpandSurface(const StereoScene& scene, std::vector<int> frontier, const Execution& execution, Surface& surface) {
  while (!frontier.empty()) {
    // The best patches choose first.
    std::stable_sort(frontier.begin(), frontier.end(),
                     [&](int a, int b) { return surface.patches[a].ncc > surface.patches[b].ncc; });
    std::vector<Candidate> candidates;
    std::vector<int> next;
    for (const int i : frontier) {
      if (ListCandidates(scene, surface.patches, i, surface.cells, candidates)) next.push_back(i);
    }
    surface.cells.ClearPending();
    std::vector<std::optional<SurfacePatch>> grown(candidates.size());
    const auto grow = [&](int i) {
      grown[i] = BuildPatch(scene, candidates[i].plane, candidates[i].hints);
      // One that left its parent's surface is a start of something else, mostly of nothing.
      if (grown[i] && !AreNeighbours(scene, *grown[i], surface.patches[candidates[i].parent])) grown[i].reset();
    };
    const bool finished = ParallelFor(execution, static_cast<int>(candidates.size()), grow, kCandidatesPerTask);
    if (!finished) return false;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!grown[i] || surface.cells.IsFilled(candidates[i].plane.reference_view, candidates[i].cell)) continue;
      surface.cells.Fill(*grown[i]);
      next.push_back(static_cast<int>(surface.patches.size()));
      surface.patches.push_back(std::move(*grown[i]));
    }
    frontier = std::move(next);
  }
  return true;
}

}  // namespace rigcal::stereo
