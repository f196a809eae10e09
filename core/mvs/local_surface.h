#pragma once

#include <optional>
#include <vector>

#include "core/mvs/cell_grid.h"

namespace rigcal::stereo {

/// The surface around a patch, from the patches around it: a quadratic function of the pixel offset in the patch's
/// reference view, fitted robustly. Depth is counted in pixels of the level (f * (w / w_patch - 1), w = inverse depth),
/// so that 1 means as much along the ray as a pixel does across it; towards the camera is positive.
struct LocalSurface {
  double value_px = 0;               ///< at the patch: how far the surface lies before it
  Eigen::Vector2d slope;             ///< per pixel to the right and down
  Eigen::Matrix2d curvature_per_px;  ///< second derivatives
  int num_neighbours = 0;            ///< that agree with it
};

/// From the others around patches[patch], so that it can be judged by them. Nothing where fewer patches lie around than
/// a quadratic needs.
std::optional<LocalSurface> FitLocalSurface(const StereoScene& scene, const std::vector<SurfacePatch>& patches,
                                            const CellIndex& index, int patch);

/// Moves every patch onto the surface that it and its neighbours lie on together, with that surface's normal, and drops
/// noisy ones that too few neighbours hold. This also takes out what a flat window gets wrong on a curved surface: a
/// plane through a window lies <u^2> / 2 * (w_uu + w_vv) beside the surface at its centre. <u^2> = h (h + 1) / 3 is
/// that of a window of half-width h with equal weights. Our weights' own is smaller, but corrected too little: on a
/// ball of 32 px radius patches lay 0.064 px off in the mean with it, 0.034 px with this. False when stopped.
bool SmoothPatches(const StereoScene& scene, const Execution& execution, std::vector<SurfacePatch>& patches);

}  // namespace rigcal::stereo
