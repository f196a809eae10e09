#include "core/rig/rig_axis.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

/// Root mean square of the two components across `axis`.
double SigmaAcross(const Eigen::Vector3d& axis, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
  return std::sqrt(std::max(0.0, (across * covariance * across).trace() / 2));
}

}  // namespace

std::optional<AxisEstimate> AxisOf(const RigEstimate& rig) {
  if (rig.model.positioner.kind != PositionerKind::kTurntable) return std::nullopt;
  const auto& mounts = rig.model.cam_from_mount;
  const auto first = std::ranges::find_if(mounts, [](const auto& mount) { return mount.has_value(); });
  if (first == mounts.end()) return std::nullopt;
  const Rigid3d& cam_from_stage = **first;  // the cameras at a turntable are mounted on the stage
  AxisEstimate axis;
  axis.camera = static_cast<int>(first - mounts.begin());
  axis.direction_in_cam = cam_from_stage.rotation * Eigen::Vector3d::UnitZ();
  axis.point_in_cam = cam_from_stage.translation;
  const int row = RigCovariance::MountRow(static_cast<int>(mounts.size()), axis.camera);
  const Eigen::Matrix<double, 6, 6> covariance = rig.covariance.joint.block<6, 6>(row, row);
  // direction' = direction + w x direction; point' = point + w x point + dt
  axis.direction_sigma_rad = SigmaAcross(axis.direction_in_cam, covariance.topLeftCorner<3, 3>());
  Eigen::Matrix<double, 3, 6> by_disturbance;
  by_disturbance << -Skew(axis.point_in_cam), Eigen::Matrix3d::Identity();
  axis.point_sigma_m = SigmaAcross(axis.direction_in_cam, by_disturbance * covariance * by_disturbance.transpose());
  return axis;
}

}  // namespace rigcal
