#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "core/match/sift_features.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

struct FeatureMatch {
  int a;
  int b;
  float similarity;  ///< of the descriptors, in [0, 1]
};

/// Pairs (a, b), a < b, of views that look at the same side of the object: each view with its `num_neighbours` nearest
/// in viewing direction, as far as those differ by less than max_angle_rad; the nearest two always.
std::vector<std::pair<int, int>> NeighbourPairs(const RigCalibration& calibration, int num_neighbours,
                                                double max_angle_rad);

/// x_b^T F x_a = 0 for full-size pixels of the undistorted pictures.
Eigen::Matrix3d FundamentalMatrix(const RigCalibration& calibration, int view_a, int view_b);

/// Where a match may lie.
struct EpipolarGate {
  Eigen::Matrix3d fundamental_b_from_a;
  double max_distance_px;  ///< from the epipolar line, in b
};

/// Features that are each other's most similar one among all that the gate lets through (everything without a gate),
/// and clearly more similar than the second (ratio test, Lowe 2004). In the order of a.
std::vector<FeatureMatch> MatchFeatures(const SiftFeatures& a, const SiftFeatures& b,
                                        const std::optional<EpipolarGate>& gate);

/// Leaves the matches that agree on one fundamental matrix, whatever the cameras say; none when they are too few to
/// have done so by more than chance. Deterministic: OpenCV's RANSAC starts from a constant.
void KeepConsistent(const SiftFeatures& a, const SiftFeatures& b, std::vector<FeatureMatch>& matches);

}  // namespace rigcal
