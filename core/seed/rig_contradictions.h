#pragma once

#include <string>
#include <vector>

#include "core/seed/corner_noise.h"
#include "core/seed/seed_cameras.h"

namespace rigcal {

/// Where the pictures and the rig model disagree after a robust fit, one sentence each, with who is at fault as far as
/// it can be told. What disagrees is taken out of the rig model in `terms`: a stop whose error is beyond its prior
/// loses the prior, a view that no stop error explains gets a pose of its own.
std::vector<std::string> TakeOutContradictions(const SeedScene& scene, const SeedOptions& options,
                                               const ChartState& state, ChartTerms& terms);

/// Components of the stop errors that are, over all stops, clearly larger than the rig file states.
std::vector<std::string> UnderstatedErrors(const SeedScene& scene, const ChartTerms& terms, const ChartState& state);

}  // namespace rigcal
