#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/rig/priors.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

/// A surface point, held constant, and where the seed's camera sees it: one element of the seed as a measurement.
struct SeedAnchor {
  int view = 0;
  Eigen::Vector3d x_in_world;
  Eigen::Vector2d seed_px;
};

/// prior.points_per_view anchors for each view, ordered by view: points of the tracks (held-out ones excepted) that the
/// view observes or, where it observes few, of all tracks that project into its picture, spread over the picture by
/// farthest-point sampling. Depends on the points, their visibility and the seed alone. A view that no point projects
/// into gets none.
std::vector<SeedAnchor> ChooseSeedAnchors(const SeedPrior& prior, const TrackSet& tracks);

}  // namespace rigcal
