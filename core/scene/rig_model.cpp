#include "core/scene/rig_model.h"

#include "core/base/ensure.h"

namespace rigcal {

std::array<const char*, kStopErrorSize> StopErrorNames(const Positioner& positioner) {
  switch (positioner.kind) {
    case PositionerKind::kTurntable:
      return {"wobble about x", "wobble about y", "step error", "run-out along x", "run-out along y", "lift"};
    case PositionerKind::kGantry:
      return {"",
              "",
              "",
              "position error of axis 1",
              positioner.num_axes > 1 ? "position error of axis 2" : "",
              positioner.num_axes > 2 ? "position error of axis 3" : ""};
    case PositionerKind::kArm:
      break;
  }
  return {"rotation about x", "rotation about y", "rotation about z",
          "shift along x",    "shift along y",    "shift along z"};
}

RigModel Turntable(double step_sigma_rad, double wobble_sigma_rad, double run_out_sigma_m) {
  RigModel rig;
  rig.positioner.kind = PositionerKind::kTurntable;
  rig.positioner.load = PositionerLoad::kObject;
  rig.error_sigma << wobble_sigma_rad, wobble_sigma_rad, step_sigma_rad, run_out_sigma_m, run_out_sigma_m, 0;
  return rig;
}

RigModel Gantry(int num_axes, PositionerLoad load, double position_sigma_m) {
  Ensure(num_axes >= 1 && num_axes <= kMaxGantryAxes, "a gantry has one to three axes");
  RigModel rig;
  rig.positioner.kind = PositionerKind::kGantry;
  rig.positioner.load = load;
  rig.positioner.num_axes = num_axes;
  rig.error_sigma.segment(3, num_axes).setConstant(position_sigma_m);
  return rig;
}

RigModel Arm(PositionerLoad load, double rotation_sigma_rad, double position_sigma_m) {
  RigModel rig;
  rig.positioner.kind = PositionerKind::kArm;
  rig.positioner.load = load;
  rig.error_sigma.head<3>().setConstant(rotation_sigma_rad);
  rig.error_sigma.tail<3>().setConstant(position_sigma_m);
  return rig;
}

}  // namespace rigcal
