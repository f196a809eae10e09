#include "core/mvs/seed.h"
#include "core/mvs/surface.h"

namespace rigcal::stereo {

bool SeedSurface(const StereoScene& scene, const Execution& execution, Surface& surface) {
  std::vector<std::vector<Feature>> features(scene.views.size());
  if (!ParallelFor(execution, scene.NumViews(), [&](int view) { features[view] = FindFeatures(scene, view); })) {
    return false;
  }
  for (int view = 0; view < scene.NumViews(); ++view) {
    const std::vector<int> partners = ViewsToMatch(scene, view);
    std::vector<Feature> open;
    for (const Feature& feature : features[view]) {
      if (!surface.cells.IsFilled(view, surface.cells.CellAt(view, {feature.u_px, feature.v_px}))) {
        open.push_back(feature);
      }
    }
    std::vector<std::optional<SurfacePatch>> seeds(open.size());
    const bool finished = ParallelFor(execution, static_cast<int>(open.size()),
                                      [&](int i) { seeds[i] = SeedPatch(scene, features, view, open[i], partners); });
    if (!finished) return false;
    for (std::optional<SurfacePatch>& seed : seeds) {
      if (!seed || surface.cells.IsFilled(view, surface.cells.CellAt(view, {seed->u_px, seed->v_px}))) continue;
      surface.cells.Fill(*seed);
      surface.patches.push_back(std::move(*seed));
    }
  }
  return true;
}

}  // namespace rigcal::stereo
