#pragma once

#include <functional>
#include <vector>

#include "core/mvs/cell_grid.h"

namespace rigcal::stereo {

/// The patches made so far and the cells they fill.
struct Surface {
  std::vector<SurfacePatch> patches;
  CellGrid cells;
};

/// Makes patches at the features of every view, in cells that are still empty (PMVS paper, section 3.1). False when
/// stopped.
bool SeedSurface(const StereoScene& scene, const Execution& execution, Surface& surface);

/// Grows patches into the empty cells beside `frontier` (indices of patches) and on from there until nothing is added
/// (PMVS paper, section 3.2). Goes in rounds: candidates are listed in order, refined in parallel, and added in order,
/// so that the outcome does not depend on the threads. False when stopped.
bool ExpandSurface(const StereoScene& scene, std::vector<int> frontier, const Execution& execution, Surface& surface);

/// Leaves the patches whose mark is set, in their order; one mark a patch.
void KeepMarked(const std::vector<char>& marks, std::vector<SurfacePatch>& patches);

/// The patches without those that contradict others or stand alone (PMVS paper, section 3.3). Nothing when stopped.
std::optional<std::vector<SurfacePatch>> FilterPatches(const StereoScene& scene, std::vector<SurfacePatch> patches,
                                                       const Execution& execution);

}  // namespace rigcal::stereo
