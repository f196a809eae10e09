#pragma once

#include <optional>
#include <vector>

#include "core/mvs/build_patch.h"
#include "core/mvs/features.h"

namespace rigcal::stereo {

/// The views in which features of `view` are looked for: those that look the same way, nearest first.
std::vector<int> ViewsToMatch(const StereoScene& scene, int view);

/// A patch at a feature of a view, from the features of `partners` near its epipolar lines (PMVS paper, section 3.1);
/// the band is as wide as the cameras' errors. `features` are those of every view.
std::optional<SurfacePatch> SeedPatch(const StereoScene& scene, const std::vector<std::vector<Feature>>& features,
                                      int view, const Feature& feature, const std::vector<int>& partners);

}  // namespace rigcal::stereo
