#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/scene/rig_model.h"

namespace rigcal {

/// Joint covariance of cameras and rig. Row and column order: for each camera kNumIntrinsics intrinsics
/// (IntrinsicIndex), then for each camera the 6 of Disturbed() of cam_from_mount, then 6 of anchor_from_world, then the
/// 9 of axes_in_stage column by column. Rows of what was not estimated are zero. Errors of single stops are not in it:
/// every recording has its own.
struct RigCovariance {
  Eigen::MatrixXd joint;
  [[nodiscard]] static int IntrinsicsRow(int camera) { return camera * kNumIntrinsics; }
  [[nodiscard]] static int MountRow(int num_cameras, int camera) { return num_cameras * kNumIntrinsics + 6 * camera; }
  [[nodiscard]] static int AnchorRow(int num_cameras) { return MountRow(num_cameras, num_cameras); }
  [[nodiscard]] static int AxesRow(int num_cameras) { return AnchorRow(num_cameras) + 6; }
  [[nodiscard]] static int Size(int num_cameras) { return AxesRow(num_cameras) + 9; }
};

/// The rig that the cameras belong to, as far as it stays the same from one recording to the next.
struct RigEstimate {
  RigModel model;                 ///< with cam_from_mount and geometry as estimated
  std::vector<std::string> axes;  ///< the positioner's axes by the names that recordings give them (docs/rig.md)
  RigCovariance covariance;
};

/// The turntable's axis as a camera sees it. Sigmas: one component across the axis.
struct AxisEstimate {
  int camera = 0;
  Eigen::Vector3d direction_in_cam = Eigen::Vector3d::UnitZ();  ///< angle > 0 turns counter-clockwise about it
  Eigen::Vector3d point_in_cam = Eigen::Vector3d::Zero();       ///< at table height
  double direction_sigma_rad = 0;
  double point_sigma_m = 0;
};

/// How the rig came out in one recording.
struct RigFit {
  Positioner positioner;
  std::vector<std::string> stop_ids;
  std::vector<StopError> stop_errors;       ///< per stop; zero for one that no camera saw
  std::vector<StopError> stop_error_sigma;  ///< per stop
  std::optional<AxisEstimate> axis;         ///< of a turntable, in the first camera that has a place in the rig
};

}  // namespace rigcal
