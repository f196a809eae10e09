#pragma once

#include <optional>
#include <vector>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// Cameras that are fixed to each other, and where they stood, as COLMAP 3.12 and later say it:
/// cam_from_world = sensor_from_rig * rig_from_world.
struct ColmapRig {
  std::vector<int> cameras;              ///< indices; the first is the reference sensor: its frame is the rig's
  std::vector<Rigid3d> sensor_from_rig;  ///< per camera of the rig; the identity for the first
};
struct ColmapFrame {
  int rig = 0;             ///< index into ColmapRigs::rigs
  std::vector<int> views;  ///< indices, at most one of each camera
  Rigid3d rig_from_world;
};
struct ColmapRigs {
  std::vector<ColmapRig> rigs;
  std::vector<ColmapFrame> frames;
};

/// One rig of all cameras that have a place in it, and one of its own for each camera that has none; every camera and
/// every view is in exactly one. Views whose rig stood at the same place are one frame; a view whose pose does not fit
/// any other's has a frame of its own, so that its pose is kept. Nothing for calibrations without a rig of two cameras
/// or more.
std::optional<ColmapRigs> ColmapRigsOf(const RigCalibration& calibration);

}  // namespace rigcal
