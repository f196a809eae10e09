#include "core/rig/free_parameters.h"

#include <algorithm>

namespace rigcal {

std::vector<int> FreeParameters::JointRows() const {
  const int num_cameras = static_cast<int>(intrinsics.size());
  std::vector<int> rows;
  for (int camera = 0; camera < num_cameras; ++camera) {
    for (int k = 0; k < kNumIntrinsics; ++k) {
      if (intrinsics[camera][k]) rows.push_back(CalibrationCovariance::IntrinsicsRow(camera) + k);
    }
  }
  for (int view = 0; view < static_cast<int>(poses.size()); ++view) {
    for (int k = 0; poses[view] && k < 6; ++k) rows.push_back(CalibrationCovariance::PoseRow(num_cameras, view) + k);
  }
  return rows;
}

bool FreeParameters::AnyPoseFixed() const {
  return std::find(poses.begin(), poses.end(), false) != poses.end();
}

FreeParameters AllPinholeParameters(const RigCalibration& calibration) {
  std::array<bool, kNumIntrinsics> pinhole{};
  pinhole[kFx] = pinhole[kFy] = pinhole[kCx] = pinhole[kCy] = true;
  return {std::vector(calibration.cameras.size(), pinhole), std::vector<bool>(calibration.views.size(), true)};
}

FreeRows RowsOf(const FreeParameters& free) {
  FreeRows rows;
  for (const auto& camera : free.intrinsics) {
    auto& row = rows.intrinsics.emplace_back();
    for (int k = 0; k < kNumIntrinsics; ++k) row[k] = camera[k] ? rows.count++ : -1;
  }
  for (const bool is_free : free.poses) {
    rows.pose.push_back(is_free ? rows.count : -1);
    if (is_free) rows.count += 6;
  }
  return rows;
}

}  // namespace rigcal
