#pragma once

#include "core/adjust/bundle.h"
#include "core/adjust/fit_quality.h"

namespace rigcal {

/// Covariance at the solution from the reduced camera system, weighted as the robust loss does and scaled by the noise
/// that was found, together with the priors at their own sigmas; with a rig also its covariance and its stops' sigmas.
/// `out` holds the solution and its tracks. Also fills weakest_directions_px, which knows no prior.
void WritePosterior(const MeasurementSet& measurements, const NoiseEstimate& noise, const BundleTerms& terms,
                    Adjustment& out);

}  // namespace rigcal
