#include "config/formats/colmap_rig.h"

#include <algorithm>

namespace rigcal {
namespace {

// Poses of one stop agree to rounding: far below what moves a picture by a millionth of a pixel.
constexpr double kMaxRotationDifferenceRad = 1e-10;
constexpr double kMaxTranslationDifference = 1e-10;  // in the calibration's unit

bool SamePlace(const Rigid3d& a, const Rigid3d& b) {
  return a.rotation.angularDistance(b.rotation) < kMaxRotationDifferenceRad &&
         (a.translation - b.translation).norm() < kMaxTranslationDifference;
}

/// Where each camera stands in its rig.
struct Place {
  int rig = 0;
  Rigid3d sensor_from_rig;
};

std::vector<Place> GatherRigs(const RigCalibration& calibration, ColmapRigs& rigs) {
  const auto& cam_from_mount = calibration.rig->model.cam_from_mount;
  std::vector<Place> places(calibration.NumCameras());
  int joint_rig = -1;
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    const bool mounted = c < static_cast<int>(cam_from_mount.size()) && cam_from_mount[c];
    if (mounted && joint_rig >= 0) {
      ColmapRig& rig = rigs.rigs[joint_rig];
      places[c] = {joint_rig, *cam_from_mount[c] * cam_from_mount[rig.cameras.front()]->Inverse()};
      rig.cameras.push_back(c);
      rig.sensor_from_rig.push_back(places[c].sensor_from_rig);
      continue;
    }
    places[c].rig = static_cast<int>(rigs.rigs.size());
    if (mounted) joint_rig = places[c].rig;
    rigs.rigs.push_back({{c}, {Rigid3d()}});
  }
  return places;
}

/// The frame of `place` at which the view fits, or a new one.
ColmapFrame& FrameFor(const RigCalibration& calibration, int v, const Place& place, ColmapRigs& rigs) {
  const Rigid3d rig_from_world = place.sensor_from_rig.Inverse() * calibration.views[v].cam_from_world;
  const auto fits = [&](const ColmapFrame& frame) {
    return frame.rig == place.rig && SamePlace(frame.rig_from_world, rig_from_world) &&
           std::none_of(frame.views.begin(), frame.views.end(),
                        [&](int other) { return calibration.views[other].camera == calibration.views[v].camera; });
  };
  const auto found = std::find_if(rigs.frames.begin(), rigs.frames.end(), fits);
  return found != rigs.frames.end() ? *found : rigs.frames.emplace_back(ColmapFrame{place.rig, {}, rig_from_world});
}

}  // namespace

std::optional<ColmapRigs> ColmapRigsOf(const RigCalibration& calibration) {
  if (!calibration.rig) return std::nullopt;
  ColmapRigs rigs;
  const std::vector<Place> places = GatherRigs(calibration, rigs);
  if (std::none_of(rigs.rigs.begin(), rigs.rigs.end(), [](const ColmapRig& rig) { return rig.cameras.size() > 1; }))
    return std::nullopt;
  for (int v = 0; v < calibration.NumViews(); ++v)
    FrameFor(calibration, v, places[calibration.views[v].camera], rigs).views.push_back(v);
  return rigs;
}

}  // namespace rigcal
