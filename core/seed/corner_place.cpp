#include "core/seed/corner_place.h"

#include <algorithm>
#include <cmath>

namespace rigcal {

CornerPlace PlaceOfCorner(const TagFamily& family, const FoundTag& tag, int corner, double gap_share) {
  const int next = (corner + 1) % kCornersPerTag, previous = (corner + kCornersPerTag - 1) % kCornersPerTag;
  CornerPlace place;
  place.x_px = tag.corners_px[corner];
  place.is_crossing = family.BorderCells() > 1;
  const std::array<Eigen::Vector2d, 2> edge = {tag.corners_px[next] - place.x_px,
                                               tag.corners_px[previous] - place.x_px};
  for (int e = 0; e < 2; ++e) {
    place.length_px[e] = edge[e].norm();
    place.along[e] = edge[e] / place.length_px[e];
  }
  const double sine = std::abs(place.along[0].x() * place.along[1].y() - place.along[0].y() * place.along[1].x());
  for (int e = 0; e < 2; ++e) {
    const double across_px = place.length_px[1 - e] * sine;  // the tag's width, measured across edge e
    const double cell_px = across_px / family.EdgeCells();
    place.inside_px[e] = cell_px * family.BorderCells();
    // A tag needs one cell around it and may have more; beyond the gap comes a neighbour.
    const double gap_px = across_px * gap_share;
    place.outside_px[e] = place.is_crossing ? gap_px : std::min(gap_px, cell_px);
  }
  return place;
}

}  // namespace rigcal
