#pragma once

#include "core/seed/find_tags.h"
#include "core/seed/refine_corner.h"
#include "core/seed/tag_family.h"

namespace rigcal {

/// What stands around a corner of a tag, by its four rough corners. `gap_share`: from its square to the next thing
/// beside it, as a share of its edge. Tags with a border of several bits are taken to stand on a Kalibr board.
CornerPlace PlaceOfCorner(const TagFamily& family, const FoundTag& tag, int corner, double gap_share);

}  // namespace rigcal
