#pragma once

#include <vector>

#include "core/base/median.h"
#include "core/rig/measurements.h"

namespace rigcal {

/// Distance of every feature from the projection of its point; infinite where that is not in front of the camera.
struct FitResiduals {
  std::vector<double> px;      ///< in the picture
  std::vector<double> sigmas;  ///< whitened: 1 is the expected size of one coordinate
};
FitResiduals ResidualsOf(const RigCalibration& calibration, const MeasurementSet& measurements);

/// Takes out the features that are grossly wrong, and then the points with fewer than two features. The measure is a
/// robust sigma of all features or of the feature's own view, whichever is larger, so that a view that has not
/// converged keeps its core. Below least_sigmas nothing is gross. Returns the measurements taken out, by their former
/// index.
std::vector<bool> DropGrossErrors(const FitResiduals& residuals, double least_sigmas, int num_views,
                                  MeasurementSet& measurements);

/// What the residuals tell of the noise, in the a-priori sigmas, and how much a feature counts.
struct NoiseEstimate {
  double sigma = 1;            ///< of one coordinate, such that unweighted normal equations give the true covariance
  double weighted_sigma = 1;   ///< the same for normal equations weighted by `weight`
  std::vector<double> weight;  ///< robust weight of each feature, in (0, 1]
};

/// For the M-estimator with a Cauchy loss of `cauchy_scale` sigmas (0: none) on the length of a 2-D residual: Huber's
/// asymptotic variance E[psi^2] / E[psi']^2 of the residuals enlarged by what fitting num_estimated parameters took,
/// with his correction K^2 for many parameters (Robust Statistics, section 7.6).
NoiseEstimate EstimateNoise(const std::vector<double>& residual_sigmas, double cauchy_scale, int num_estimated);

}  // namespace rigcal
