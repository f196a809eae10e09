#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/rig_calibration.h"
#include "sim_fixtures/surface.h"

namespace rigcal::sim {

struct DisturbOptions {
  double mean_px = 6;             ///< mean displacement of the points in the pictures, without any alignment
  bool shared_intrinsics = true;  ///< one disturbance of the intrinsics per camera; otherwise one per view
  std::uint64_t random_seed = 1;
};

/// Cameras that are wrong by mean_px, the way a seed is: focal length (fx / fy stays as it is), principal point and
/// every view's rotation (about the camera's own axes, in place) and translation (camera's frame) get normal errors,
/// each with the standard deviation that alone moves the points by the same RMS amount, times one factor that makes the
/// mean displacement exactly mean_px. Without shared_intrinsics the result has one camera per view. `points` name views
/// of `truth`; at least one point must be seen.
RigCalibration Disturb(const RigCalibration& truth, const std::vector<VisiblePoint>& points,
                       const DisturbOptions& options);

/// Mean distance in pixels between the points' projections by two calibrations with the same views.
double MeanDisplacement_px(const RigCalibration& a, const RigCalibration& b, const std::vector<VisiblePoint>& points);

}  // namespace rigcal::sim
