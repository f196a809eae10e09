#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/scene/rig_calibration.h"
#include "core/validate/compare.h"

namespace rigcal::test {

/// cam_from_world of a camera at `centre_in_world` that looks at `target_in_world`, world +z up in the picture.
Rigid3d LookingAt(const Eigen::Vector3d& centre_in_world, const Eigen::Vector3d& target_in_world);

/// The same cameras in another frame: x_in_new = scale * rotation * x_in_world + translation.
RigCalibration InFrame(const RigCalibration& calibration, double scale, const Eigen::Quaterniond& rotation,
                       const Eigen::Vector3d& translation);

/// Six cameras (1000 px, 640x480) 45 degrees apart, rising, 2 m from the origin, and a 4x4x4 lattice of +-0.3 m.
RigCalibration SixCameras();
std::vector<ComparePoint> LatticePoints();

/// Every view with a camera of its own, every parameter off by a fixed sine, and the whole in another frame (scale
/// 2.5): amplitude 1 is about 6 px on SixCameras.
RigCalibration DisturbedBySines(const RigCalibration& calibration, double amplitude);

/// A set of ../shared/data below RIGCAL_DATA: Middlebury cameras and their object points; nothing without the variable.
struct RecordedCameras {
  RigCalibration calibration;
  std::vector<ComparePoint> points;
};
std::optional<RecordedCameras> ReadRecordedCameras(const std::string& folder, const std::string& par_name, int width_px,
                                                   int height_px);

}  // namespace rigcal::test
