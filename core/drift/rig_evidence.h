#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/drift/judge_drift.h"

namespace rigcal {

/// What a recording alone says of cameras and rig, apart from what was known before: normal, over RigPrior::FreeRows of
/// the released prior. `information` is singular along everything that no picture shows.
struct RigEvidence {
  std::vector<int> rows;        ///< of RigCovariance
  Eigen::MatrixXd information;  ///< of the departure from the calibration in force
  Eigen::VectorXd pull;         ///< information * that departure
  Eigen::MatrixXd stated_root;  ///< root * root^T is the covariance that the calibration in force states
};

/// Takes the prior out of what was found with it: information = posterior^-1 - prior^-1.
RigEvidence EvidenceOf(const DriftInput& input);

inline constexpr int kMotionSize = 6;  ///< a rigid motion: three rotations (rad), three translations (m)
using MotionVector = Eigen::Matrix<double, kMotionSize, 1>;
using MotionMatrix = Eigen::Matrix<double, kMotionSize, kMotionSize>;

/// Something that may have moved since, by a rigid motion of its own.
struct Mover {
  Eigen::MatrixXd by_motion;  ///< departure of RigEvidence::rows by the motion
  MotionVector width;         ///< sigma of what it may have moved by
};

/// The night explained by motions of some movers, and by errors of the calibration in force, which are none.
struct Explanation {
  std::vector<MotionVector> motion;
  std::vector<MotionMatrix> covariance;
  double fit = 0;  ///< chi-square that it explains
  double log_evidence =
      0;  ///< twice the logarithm of its density, but for a constant: more movers must earn their place
};

/// Bayes' theorem for normal densities: errors of the calibration in force about zero with its covariance, motions
/// about zero with their width.
Explanation Explain(const RigEvidence& evidence, const std::vector<Mover>& movers);

}  // namespace rigcal
