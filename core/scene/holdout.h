#pragma once

#include <cstdint>

#include "core/scene/track.h"

namespace rigcal {

/// Marks about `share` (in [0, 1)) of the tracks as held out, and clears the mark of the others. The choice follows
/// from `random_seed` alone and is spread over the views: each gives about the same share of its features (DESIGN.md
/// section 4).
void HoldOut(TrackSet& tracks, double share, std::uint64_t random_seed);

}  // namespace rigcal
