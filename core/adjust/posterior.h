#pragma once

#include <vector>

#include "core/adjust/bundle.h"
#include "core/adjust/fit_quality.h"

namespace rigcal {

struct Posterior {
  CalibrationCovariance covariance;
  std::vector<double> weakest_directions_px;  ///< without the priors, see WeakestDirectionsPx()
};

/// Covariance at the solution from the reduced camera system, weighted as the robust loss does and scaled by the noise
/// that was found, together with the priors at their own sigmas.
Posterior PosteriorAt(const RigCalibration& solution, const MeasurementSet& measurements, const NoiseEstimate& noise,
                      const BundleTerms& terms, const TrackSet& tracks);

}  // namespace rigcal
