#pragma once

#include <vector>

#include "core/mvs/stereo_scene.h"

namespace rigcal::stereo {

struct Feature {
  int u_px = 0;
  int v_px = 0;
};

/// Corners (Harris) and blobs (difference of Gaussians) of one view: the strongest few local maxima of each in every
/// block of a regular grid, so that they cover the object (PMVS paper, section 3.1). Sorted by row and column.
std::vector<Feature> FindFeatures(const StereoScene& scene, int view);

}  // namespace rigcal::stereo
