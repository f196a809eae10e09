#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/rig/free_parameters.h"
#include "core/rig/measurements.h"
#include "core/rig/priors.h"
#include "core/rig/seed_anchors.h"

namespace rigcal {

/// The reduced camera system: what the features say about the free camera parameters once every point has been
/// eliminated (Schur complement of the normal equations), over the free vector. Each measurement counts with the square
/// of its whitening: a caller that down-weights outliers scales it beforehand. Without priors it is singular along the
/// gauge, and nearly so along everything else that the features do not determine.
Eigen::MatrixXd FeatureInformation(const RigCalibration& calibration, const FreeParameters& free,
                                   const MeasurementSet& measurements);

/// What the seed says about the free parameters, sigma_px (Er) for each anchor's coordinate: the density of the truth
/// that the adjustment assumes is N(seed, (SeedInformation + IntrinsicsInformation)^-1).
Eigen::MatrixXd SeedInformation(const RigCalibration& calibration, const FreeParameters& free,
                                std::span<const SeedAnchor> anchors, double sigma_px);

/// What the priors on principal point and aspect say; `priors` has one entry per camera or none at all.
Eigen::MatrixXd IntrinsicsInformation(const RigCalibration& calibration, const FreeParameters& free,
                                      std::span<const CameraPrior> priors);

/// Inverse of a symmetric positive (semi-)definite matrix whose rows have different units: it is scaled to a unit
/// diagonal first. Directions whose eigenvalue is then below 1e-13 of the largest carry no information that double
/// precision could tell from none and get the variance of that limit: huge, not infinite.
Eigen::MatrixXd CovarianceFromInformation(const Eigen::MatrixXd& information);
/// A square root of the same: covariance = root * root^T.
Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& information);

}  // namespace rigcal
