#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/rigid3.h"

namespace rigcal {

enum class PositionerKind { kTurntable, kGantry, kArm };
/// What the positioner carries. A turntable carries the object.
enum class PositionerLoad { kObject, kCameras };

/// Where the positioner stood, as commanded or as it reported.
struct StopPosition {
  std::string id;
  std::vector<double> axes;                 ///< turntable: the angle (rad); gantry: one value per axis (m)
  std::optional<Rigid3d> base_from_flange;  ///< arm
};

inline constexpr int kStopErrorSize = 6;
/// How a stop differs from what was commanded: three small rotations (rad), then three small translations (m).
///   turntable: about x, y (wobble) and z (step error) of the stage; along x, y (run-out), z (lift) of the stage
///   gantry:    unused; along each of the (up to three) axes
///   arm:       about x, y, z and along x, y, z of the flange
using StopError = Eigen::Matrix<double, kStopErrorSize, 1>;
enum TurntableError { kWobbleX, kWobbleY, kStep, kRunOutX, kRunOutY, kLift };
inline constexpr int kMaxGantryAxes = 3;

/// The moving part of the studio: what a stop's position means.
struct Positioner {
  PositionerKind kind = PositionerKind::kTurntable;
  PositionerLoad load = PositionerLoad::kObject;
  /// Arm only, the half of the hand-eye problem that the cameras do not carry: base_from_world when the arm carries the
  /// cameras, flange_from_world when it carries the object.
  Rigid3d anchor_from_world;
  /// Gantry only, a column for each axis: how the carriage moves in the stage for one metre commanded (about unit
  /// length).
  Eigen::Matrix3d axes_in_stage = Eigen::Matrix3d::Identity();
  int num_axes = 0;  ///< gantry only
};

/// Names of a stop error's components, for reports; empty for one that the positioner does not have.
std::array<const char*, kStopErrorSize> StopErrorNames(const Positioner& positioner);

/// Positioner, cameras and how exactly it all repeats (DESIGN.md section 5). `world` is fixed to the object; with a
/// turntable it is the table: z is the axis, the origin lies on it at table height. `stage` is the studio; `mount` what
/// carries the camera: the stage, a gantry's carriage or an arm's flange.
struct RigModel {
  Positioner positioner;
  StopError error_sigma = StopError::Zero();           ///< expected size of each component; 0: exact
  double axis_scale_sigma = 1e-3;                      ///< gantry: relative error of an axis's length unit
  std::vector<std::optional<Rigid3d>> cam_from_mount;  ///< per camera; nothing: unknown
};

/// A turntable as exact as its maker says. Defaults: a stepper-driven table of a scan station (DESIGN.md section 1).
RigModel Turntable(double step_sigma_rad = 5e-4, double wobble_sigma_rad = 3.5e-4, double run_out_sigma_m = 1e-5);
RigModel Gantry(int num_axes, PositionerLoad load, double position_sigma_m = 5e-5);
RigModel Arm(PositionerLoad load, double rotation_sigma_rad = 2e-4, double position_sigma_m = 1e-4);

}  // namespace rigcal
