#pragma once

#include "config/rig_views.h"
#include "core/adjust/adjust.h"

namespace rigcal {

/// What the adjustment has to know of the rig whose views these are: the calibration's own covariance as the prior,
/// stops without errors to start with. `placed`: from the same calibration.
RigTerms RigTermsOf(const RigViews& placed);

/// Lets every mount and lens depart a little more from what the calibration says: what may have crept since.
void AllowForCreep(RigTerms& terms);

}  // namespace rigcal
