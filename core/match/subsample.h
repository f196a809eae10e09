#pragma once

#include <vector>

#include "core/match/match.h"
#include "core/match/patch_frame.h"

namespace rigcal {

/// Which patches to match (paper section 3.1): every picture is divided into blocks, at most epsilon features of a
/// block are drawn at random, and a patch is kept when one of its features was drawn. epsilon is the smallest number
/// with which options.kept_share of the patches remain (less when these have more than options.max_features features);
/// views left with fewer than options.min_features_per_view features then get more of theirs. Indices into `patches`,
/// ascending.
std::vector<int> SubsamplePatches(const std::vector<Patch>& patches, const std::vector<ViewGeometry>& views,
                                  const ImageSet& images, const MatchOptions& options);

}  // namespace rigcal
