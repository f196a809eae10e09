#include "core/rig/rig_model_pose.h"

#include <Eigen/QR>
#include <cmath>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

Rigid3d SmallMotion(const StopError& error) {
  return {ExpRotation(error.head<3>()), error.tail<3>()};
}

/// How SmallMotion(error) is disturbed by its six numbers.
Matrix6d SmallMotionDisturbance(const StopError& error) {
  Matrix6d out = Matrix6d::Identity();
  out.topLeftCorner<3, 3>() = LeftJacobian(error.head<3>());
  out.bottomLeftCorner<3, 3>() = Skew(error.tail<3>()) * out.topLeftCorner<3, 3>();
  return out;
}

Rigid3d AboutZ(double angle_rad) {
  return {ExpRotation({0, 0, angle_rad}), Eigen::Vector3d::Zero()};
}

const Rigid3d& FlangePose(const StopPosition& position) {
  Ensure(position.base_from_flange.has_value(), "a stop of an arm has a flange pose");
  return *position.base_from_flange;
}

/// Sign of the carriage's motion in world -> mount: moving the cameras along is moving the world back.
double GantrySign(const Positioner& positioner) {
  return positioner.load == PositionerLoad::kObject ? 1 : -1;
}

Rigid3d GantryMotion(const Positioner& positioner, const StopPosition& position, const StopError& error) {
  Rigid3d motion;
  for (int k = 0; k < positioner.num_axes; ++k) {
    motion.translation += GantrySign(positioner) * (position.axes[k] + error[3 + k]) * positioner.axes_in_stage.col(k);
  }
  return motion;
}

}  // namespace

Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& w_rad) {
  const double angle = w_rad.norm();
  const Eigen::Matrix3d w = Skew(w_rad);
  if (angle < 1e-4) return Eigen::Matrix3d::Identity() + 0.5 * w + w * w / 6;  // the next term is below 1e-13
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / a2 * w +
         (angle - std::sin(angle)) / (a2 * angle) * w * w;
}

Matrix6d DisturbanceThrough(const Rigid3d& c_from_b) {
  const Eigen::Matrix3d r = c_from_b.rotation.toRotationMatrix();
  Matrix6d out;
  out << r, Eigen::Matrix3d::Zero(), Skew(c_from_b.translation) * r, r;
  return out;
}

StopMotion MotionAt(const Positioner& positioner, const StopPosition& position, const StopError& error) {
  StopMotion motion;
  const bool moves_object = positioner.load == PositionerLoad::kObject;
  switch (positioner.kind) {
    case PositionerKind::kTurntable:
      Ensure(moves_object && position.axes.size() == 1, "a turntable carries the object and has one angle");
      motion.stage_from_world = SmallMotion(error) * AboutZ(position.axes[0]);
      break;
    case PositionerKind::kGantry:
      Ensure(static_cast<int>(position.axes.size()) == positioner.num_axes,
             "a gantry's stop has a value for each axis");
      (moves_object ? motion.stage_from_world : motion.mount_from_stage) = GantryMotion(positioner, position, error);
      break;
    case PositionerKind::kArm:
      if (moves_object) {  // stage = base, world = object: base_from_flange * error * flange_from_world
        motion.stage_from_world = FlangePose(position) * SmallMotion(error) * positioner.anchor_from_world;
      } else {  // mount = flange, stage = base
        motion.mount_from_stage = SmallMotion(error) * FlangePose(position).Inverse();
        motion.stage_from_world = positioner.anchor_from_world;
      }
      break;
  }
  return motion;
}

Rigid3d CamFromWorld(const Rigid3d& cam_from_mount, const StopMotion& motion) {
  return cam_from_mount * motion.mount_from_stage * motion.stage_from_world;
}

StopPosition StopAt(const Positioner& positioner, const Rigid3d& cam_from_mount, const Rigid3d& cam_from_world) {
  const Rigid3d mount_from_world = cam_from_mount.Inverse() * cam_from_world;
  StopPosition position;
  switch (positioner.kind) {
    case PositionerKind::kTurntable: {
      const Eigen::Matrix3d r = mount_from_world.rotation.toRotationMatrix();
      position.axes = {std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1))};  // the nearest turn about z
      break;
    }
    case PositionerKind::kGantry: {
      const auto axes = positioner.axes_in_stage.leftCols(positioner.num_axes);
      const Eigen::VectorXd values =
          axes.colPivHouseholderQr().solve(GantrySign(positioner) * mount_from_world.translation);
      position.axes.assign(values.begin(), values.end());
      break;
    }
    case PositionerKind::kArm:
      position.base_from_flange = positioner.load == PositionerLoad::kObject
                                      ? mount_from_world * positioner.anchor_from_world.Inverse()
                                      : positioner.anchor_from_world * mount_from_world.Inverse();
      break;
  }
  return position;
}

void PlaceViews(const RigModel& model, std::span<const StopPosition> stops, std::span<const StopError> stop_errors,
                std::span<const int> stop_of_view, RigCalibration& calibration) {
  for (int v = 0; v < calibration.NumViews(); ++v) {
    View& view = calibration.views[v];
    const int stop = stop_of_view[v];
    const StopMotion motion = MotionAt(model.positioner, stops[stop], stop_errors[stop]);
    view.cam_from_world = CamFromWorld(model.cam_from_mount[view.camera].value(), motion);
  }
}

RigPose RigPoseAt(const Positioner& positioner, const Rigid3d& cam_from_mount, const StopPosition& position,
                  const StopError& error) {
  RigPose pose;
  pose.cam_from_world = CamFromWorld(cam_from_mount, MotionAt(positioner, position, error));
  pose.by_mount.setIdentity();
  pose.by_stop_error.setZero();
  pose.by_anchor.setZero();
  pose.by_axes.setZero();
  const bool moves_object = positioner.load == PositionerLoad::kObject;
  if (positioner.kind == PositionerKind::kGantry) {
    const Eigen::Matrix3d r = GantrySign(positioner) * cam_from_mount.rotation.toRotationMatrix();
    for (int k = 0; k < positioner.num_axes; ++k) {
      pose.by_stop_error.block<3, 1>(3, 3 + k) = r * positioner.axes_in_stage.col(k);
      pose.by_axes.block<3, 3>(3, 3 * k) = (position.axes[k] + error[3 + k]) * r;
    }
    return pose;
  }
  const bool arm = positioner.kind == PositionerKind::kArm;
  const Rigid3d cam_from_error = arm && moves_object ? cam_from_mount * FlangePose(position) : cam_from_mount;
  pose.by_stop_error = DisturbanceThrough(cam_from_error) * SmallMotionDisturbance(error);
  if (arm) pose.by_anchor = DisturbanceThrough(pose.cam_from_world * positioner.anchor_from_world.Inverse());
  return pose;
}

}  // namespace rigcal
