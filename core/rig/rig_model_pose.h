#pragma once

#include <Eigen/Core>
#include <span>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// What the positioner has done at a stop.
struct StopMotion {
  Rigid3d mount_from_stage, stage_from_world;
};

/// Angle > 0 turns the object counter-clockwise seen from above (world z up); a gantry's axis value > 0 moves what it
/// carries along the axis; an arm's flange stands at base_from_flange. The stop's error comes last in the chain of a
/// turntable (in the stage) and at the flange of an arm.
StopMotion MotionAt(const Positioner& positioner, const StopPosition& position, const StopError& error);

/// cam_from_world = cam_from_mount * mount_from_stage(stop) * stage_from_world(stop): the one place where it stands.
Rigid3d CamFromWorld(const Rigid3d& cam_from_mount, const StopMotion& motion);

/// The stop at which a camera with this mount has this pose, in everything that a position says: the inverse of
/// CamFromWorld. A stop's error is counted into the position as far as the position can hold it (a turntable's wobble
/// is lost).
StopPosition StopAt(const Positioner& positioner, const Rigid3d& cam_from_mount, const Rigid3d& cam_from_world);

/// The same as CamFromWorld with its derivative: how the pose is disturbed (Disturbed(), 6 rows) by ...
struct RigPose {
  Rigid3d cam_from_world;
  Eigen::Matrix<double, 6, 6> by_mount;       ///< ... the disturbance of cam_from_mount
  Eigen::Matrix<double, 6, 6> by_stop_error;  ///< ... the stop's error
  Eigen::Matrix<double, 6, 6> by_anchor;      ///< ... the disturbance of anchor_from_world; zero but for an arm
  Eigen::Matrix<double, 6, 9> by_axes;        ///< ... axes_in_stage, column by column; zero but for a gantry
};
RigPose RigPoseAt(const Positioner& positioner, const Rigid3d& cam_from_mount, const StopPosition& position,
                  const StopError& error);

/// Gives every view of the calibration its pose at its stop. All cameras with views have a mount.
void PlaceViews(const RigModel& model, std::span<const StopPosition> stops, std::span<const StopError> stop_errors,
                std::span<const int> stop_of_view, RigCalibration& calibration);

/// How a disturbance of b_from_a disturbs c_from_a = c_from_b * b_from_a.
Eigen::Matrix<double, 6, 6> DisturbanceThrough(const Rigid3d& c_from_b);

/// Exp(w + dw) = Exp(LeftJacobian(w) dw) Exp(w) to first order.
Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w_rad);

}  // namespace rigcal
