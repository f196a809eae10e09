#include "core/mvs/reconstruct.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/mvs/local_surface.h"
#include "core/mvs/stereo_scene.h"
#include "core/mvs/surface.h"

namespace rigcal {
namespace {

/// Expanding and filtering in turns: what a filter frees is filled again (the PMVS paper does three).
constexpr int kTurns = 2;

Patch Published(const stereo::SurfacePatch& patch) {
  Patch out{patch.centre_in_world, patch.normal_in_world, patch.sightings[0].view, {}, patch.ncc};
  for (const stereo::Sighting& sighting : patch.sightings) out.visible_views.push_back(sighting.view);
  std::sort(out.visible_views.begin(), out.visible_views.end());
  return out;
}

}  // namespace

Result<std::vector<Patch>> Reconstruct(const ImageSet& images, const RigCalibration& calibration,
                                       const StereoOptions& options, const Execution& execution) {
  if (images.NumViews() < options.min_views) return std::vector<Patch>{};
  const std::optional<stereo::StereoScene> made = stereo::MakeStereoScene(images, calibration, options, execution);
  if (!made) return Cancelled("the stereo");
  const stereo::StereoScene& scene = *made;
  stereo::Surface surface{{}, stereo::CellGrid(scene)};
  if (!stereo::SeedSurface(scene, execution, surface)) return Cancelled("the stereo");
  execution.Report(1.0 / (kTurns + 1));
  for (int turn = 0; turn < kTurns; ++turn) {
    std::vector<int> all(surface.patches.size());
    std::iota(all.begin(), all.end(), 0);
    if (!stereo::ExpandSurface(scene, std::move(all), execution, surface)) return Cancelled("the stereo");
    std::optional<std::vector<stereo::SurfacePatch>> kept =
        stereo::FilterPatches(scene, std::move(surface.patches), execution);
    if (!kept) return Cancelled("the stereo");
    surface.patches = std::move(*kept);
    surface.cells.ClearFilled();
    for (const stereo::SurfacePatch& patch : surface.patches) surface.cells.Fill(patch);
    execution.Report((turn + 2.0) / (kTurns + 1));
  }
  if (!stereo::SmoothPatches(scene, execution, surface.patches)) return Cancelled("the stereo");
  std::vector<Patch> patches;
  patches.reserve(surface.patches.size());
  for (const stereo::SurfacePatch& patch : surface.patches) patches.push_back(Published(patch));
  return patches;
}

}  // namespace rigcal
