#pragma once

#include <array>
#include <vector>

#include "core/scene/rig_calibration.h"

namespace rigcal {

/// Which parameters of a calibration are estimated. The free ones, in the order of CalibrationCovariance, make up the
/// rows of a "free vector".
struct FreeParameters {
  std::vector<std::array<bool, kNumIntrinsics>> intrinsics;  ///< per camera
  std::vector<bool> poses;                                   ///< per view

  /// Row in CalibrationCovariance::joint of every row of the free vector.
  [[nodiscard]] std::vector<int> JointRows() const;
  [[nodiscard]] bool AnyPoseFixed() const;
};

/// fx fy cx cy of every camera and all poses: what rigcal adjusts by default.
FreeParameters AllPinholeParameters(const RigCalibration& calibration);

/// Where the parameters stand in a free vector; -1: not free.
struct FreeRows {
  std::vector<std::array<int, kNumIntrinsics>> intrinsics;  ///< per camera
  std::vector<int> pose;                                    ///< per view, the first of its 6
  int count = 0;
};
FreeRows RowsOf(const FreeParameters& free);

}  // namespace rigcal
