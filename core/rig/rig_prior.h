#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

#include "core/rig/priors.h"

namespace rigcal {

/// How far cameras and rig are from the prior's mean, rows as in RigCovariance; zero where a camera has no mount.
Eigen::VectorXd DepartureFrom(const RigPrior& prior, const std::vector<Camera>& cameras, const RigModel& model);

/// Lets a camera's mount depart from the prior by so much more, independently of everything else.
void LoosenMount(int camera, double sigma_rad, double sigma_m, RigPrior& prior);

/// Lets a camera's lens depart from the prior by so much more: its focal lengths together by a share of themselves, its
/// principal point in each direction. What the prior holds stays held.
void LoosenLens(int camera, double focal_share_sigma, double centre_sigma_px, RigPrior& prior);

/// covariance^(-1/2) * (departure from the prior), a residual for each free row. Blocks: the intrinsics of every
/// camera, the mount of every camera (PoseBlock), anchor_from_world (PoseBlock), axes_in_stage.
class RigPriorResidual : public ceres::CostFunction {
 public:
  explicit RigPriorResidual(const RigPrior& prior);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  RigPrior prior_;
  Eigen::MatrixXd whitening_;  ///< free rows x RigCovariance::Size
};

}  // namespace rigcal
