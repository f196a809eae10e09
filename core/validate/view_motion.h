#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/scene/rig_calibration.h"
#include "core/validate/compare.h"

namespace rigcal {

/// How the pictures of object points moved in one view from the reference's cameras to the estimate's.
struct ViewMotion {
  int reference_view = 0, estimate_view = 0;
  double moved_px = 0;                                 ///< mean length of the shift
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  ///< mean shift in the picture (+x right, +y down)
};

/// For every view that both have (paired by name) and that sees any of the points, after the best similarity between
/// the two. Empty without points or with fewer than two common views: nothing can be aligned.
std::vector<ViewMotion> ViewMotions(const RigCalibration& reference, const RigCalibration& estimate,
                                    const std::vector<ComparePoint>& points);

}  // namespace rigcal
