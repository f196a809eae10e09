#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "core/mvs/local_surface.h"
#include "core/mvs/surface.h"

namespace rigcal::stereo {
namespace {

/// Least share of a patch's surrounding patches that continue its surface (PMVS paper, section 3.3: 0.25).
constexpr double kMinNeighbourShare = 0.25;
constexpr int kMinNeighbours = 3;
/// Largest distance from the surface that the patches around lie on, pixels of the level: what counts as far off when
/// patches are judged. With 1.0 along the ray a third of templeSparseRing's went (level 2: 3,225 of 4,799).
constexpr double kMaxDistancePx = 2.0;
constexpr int kMinGroup = 12;  ///< patches of a connected piece of surface at least
constexpr int kReach = 2;      ///< cells around a patch in which its neighbours are looked for
constexpr int kPatchesPerTask = 64;

struct Judge {
  const StereoScene& scene;
  const std::vector<SurfacePatch>& patches;
  const CellIndex& index;
};

/// What lies side by side is then side by side in memory, too: the filters ask for neighbours all the time.
void SortByPlace(std::vector<SurfacePatch>& patches) {
  const auto place = [](const SurfacePatch& p) { return std::tuple(p.sightings[0].view, p.v_px, p.u_px); };
  std::stable_sort(patches.begin(), patches.end(),
                   [&](const SurfacePatch& a, const SurfacePatch& b) { return place(a) < place(b); });
}

/// Removes the hidden ones but the reference, which counts as one that is left; the NCC is then that of the rest.
void KeepSightings(const std::vector<char>& hidden, SurfacePatch& patch) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < hidden.size(); ++i) {
    if (hidden[i] && i > 0) continue;
    patch.sightings[next] = patch.sightings[i], patch.pixels[next] = patch.pixels[i];
    ++next;
  }
  patch.sightings.resize(next), patch.pixels.resize(next);
  patch.ncc = MeanNcc(patch.sightings);
}

/// Which of a patch's sightings lie behind another surface.
std::vector<char> HiddenSightings(const Judge& judge, const SurfacePatch& patch) {
  std::vector<char> hidden(patch.sightings.size(), 0);
  for (std::size_t i = 0; i < patch.sightings.size(); ++i) {
    const Pixel& pixel = patch.pixels[i];
    judge.index.ForNeighbours(patch.sightings[i].view, pixel.x_px, 0, [&](const CellIndex::Entry& other) {
      if (!(other.depth < static_cast<float>(pixel.depth))) return;
      if (!AreNeighbours(judge.scene, patch, judge.patches[other.patch])) hidden[i] = 1;
    });
  }
  return hidden;
}

/// Takes the hidden sightings away; patches of which too little is left go.
bool DropHidden(const StereoScene& scene, const Execution& execution, std::vector<SurfacePatch>& patches) {
  const CellIndex index(scene, patches, execution);
  const Judge judge{scene, patches, index};
  std::vector<std::vector<char>> hidden(patches.size());
  const bool finished = ParallelFor(
      execution, static_cast<int>(patches.size()), [&](int i) { hidden[i] = HiddenSightings(judge, patches[i]); },
      kPatchesPerTask);
  if (!finished) return false;
  for (std::size_t i = 0; i < patches.size(); ++i) KeepSightings(hidden[i], patches[i]);
  std::erase_if(patches, [&scene](const SurfacePatch& patch) {
    return static_cast<int>(patch.sightings.size()) < scene.options.min_views || patch.ncc < scene.options.min_ncc;
  });
  return true;
}

/// Whether the patch does not fight with better ones for its cells.
bool IsBest(const Judge& judge, const SurfacePatch& patch) {
  std::set<int> rivals;
  float rivals_ncc = 0;
  for (std::size_t i = 0; i < patch.sightings.size(); ++i) {
    judge.index.ForNeighbours(patch.sightings[i].view, patch.pixels[i].x_px, 0, [&](const CellIndex::Entry& other) {
      const SurfacePatch& q = judge.patches[other.patch];
      if (&q == &patch || AreNeighbours(judge.scene, patch, q)) return;
      if (rivals.insert(other.patch).second) rivals_ncc += q.ncc;
    });
  }
  return static_cast<float>(patch.sightings.size()) * patch.ncc >= rivals_ncc;
}

/// Whether enough of the patches around continue its surface.
bool IsSupported(const Judge& judge, const SurfacePatch& patch) {
  int others = 0, neighbours = 0;
  for (std::size_t i = 0; i < patch.sightings.size(); ++i) {
    judge.index.ForNeighbours(patch.sightings[i].view, patch.pixels[i].x_px, 1, [&](const CellIndex::Entry& other) {
      const SurfacePatch& q = judge.patches[other.patch];
      if (&q == &patch) return;
      ++others;
      if (AreNeighbours(judge.scene, patch, q)) ++neighbours;
    });
  }
  return neighbours >= kMinNeighbours && neighbours >= kMinNeighbourShare * others;
}

/// Whether it lies on the surface that the others around lie on.
bool IsSmooth(const Judge& judge, const SurfacePatch& patch) {
  const int index = static_cast<int>(&patch - judge.patches.data());
  const std::optional<LocalSurface> surface = FitLocalSurface(judge.scene, judge.patches, judge.index, index);
  if (!surface) return false;
  const double cosine = 1 / std::sqrt(1 + surface->slope.squaredNorm());  // from along the ray to across the surface
  const double error_px = judge.scene.views[patch.sightings[0].view].error_px;
  return cosine * std::abs(surface->value_px) < kMaxDistancePx + error_px;
}

bool Keep(const StereoScene& scene, const Execution& execution, std::vector<SurfacePatch>& patches,
          bool (*passes)(const Judge&, const SurfacePatch&)) {
  const CellIndex index(scene, patches, execution);
  const Judge judge{scene, patches, index};
  std::vector<char> kept(patches.size());
  const bool finished = ParallelFor(
      execution, static_cast<int>(patches.size()), [&](int i) { kept[i] = passes(judge, patches[i]); },
      kPatchesPerTask);
  if (!finished) return false;
  KeepMarked(kept, patches);
  return true;
}

/// Removes pieces of surface with fewer than kMinGroup patches; too many when stopped.
void DropSmallGroups(const StereoScene& scene, const Execution& execution, std::vector<SurfacePatch>& patches) {
  const CellIndex index(scene, patches, execution);
  std::vector<int> group(patches.size(), -1);
  std::vector<int> size;
  for (std::size_t start = 0; start < patches.size(); ++start) {
    if (group[start] >= 0) continue;
    const int id = static_cast<int>(size.size());
    size.push_back(0);
    std::vector<int> open{static_cast<int>(start)};
    group[start] = id;
    while (!open.empty()) {
      const SurfacePatch& p = patches[open.back()];
      open.pop_back();
      ++size[id];
      index.ForNeighbours(p.sightings[0].view, p.pixels[0].x_px, kReach, [&](const CellIndex::Entry& other) {
        if (group[other.patch] >= 0 || !AreNeighbours(scene, p, patches[other.patch])) return;
        group[other.patch] = id;
        open.push_back(other.patch);
      });
    }
  }
  std::vector<char> kept(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) kept[i] = size[group[i]] >= kMinGroup;
  KeepMarked(kept, patches);
}

}  // namespace

void KeepMarked(const std::vector<char>& marks, std::vector<SurfacePatch>& patches) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (!marks[i]) continue;
    if (next != i) patches[next] = std::move(patches[i]);
    ++next;
  }
  patches.resize(next);
}

std::optional<std::vector<SurfacePatch>> FilterPatches(const StereoScene& scene, std::vector<SurfacePatch> patches,
                                                       const Execution& execution) {
  SortByPlace(patches);
  if (!DropHidden(scene, execution, patches)) return std::nullopt;
  if (!Keep(scene, execution, patches, IsBest)) return std::nullopt;
  if (!Keep(scene, execution, patches, IsSupported)) return std::nullopt;
  if (!Keep(scene, execution, patches, IsSmooth)) return std::nullopt;
  DropSmallGroups(scene, execution, patches);
  if (execution.Stopped()) return std::nullopt;
  return patches;
}

}  // namespace rigcal::stereo
