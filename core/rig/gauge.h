#pragma once

#include <Eigen/Core>
#include <span>

#include "core/rig/seed_anchors.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// x_in_b = scale * b_from_a * x_in_a.
struct Similarity3d {
  double scale = 1;
  Rigid3d b_from_a;
};
Eigen::Vector3d operator*(const Similarity3d& b_from_a, const Eigen::Vector3d& x_in_a);

/// The same cameras in another world frame: every picture stays as it is. A covariance is taken along.
RigCalibration InFrame(const RigCalibration& calibration, const Similarity3d& new_from_old_world);

/// How the parameters (rows as in CalibrationCovariance) move when the world turns about x, y, z (radians), shifts
/// along x, y, z and grows: the seven directions that no picture shows. They mean something only while no pose is
/// fixed.
Eigen::Matrix<double, Eigen::Dynamic, 7> GaugeDirections(const RigCalibration& calibration);

/// new_from_old_world that brings the calibration's pictures of the anchors nearest to the seed's (least squares in
/// pixels): the gauge of the seed prior. Identity when the anchors do not determine it.
Similarity3d AlignmentToSeed(const RigCalibration& calibration, std::span<const SeedAnchor> anchors);

}  // namespace rigcal
