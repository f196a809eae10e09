#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// A point of the object and the views that it is judged in (indices into the reference's views; empty: all).
struct ComparePoint {
  Eigen::Vector3d x_in_world;
  std::vector<int> views;
};

/// Distances in pixels between the projections of object points by the reference and by the aligned estimate.
struct CompareReport {
  int num_views = 0;  ///< views that both have
  double mean_px = 0, median_px = 0, rms_px = 0, p95_px = 0, max_px = 0;
  std::vector<double> view_mean_px;  ///< per common view
  double rotation_mean_deg = 0, rotation_max_deg = 0;
  double centre_relative = 0;  ///< distance of the camera centres by their distance to the object
  double focal_relative = 0;
};

enum class CompareAlignment { kSimilarity, kProjectivity };

/// How far the estimate's cameras are from the reference's, after the best similarity (7 parameters; soft-L1 of 2 px)
/// or projectivity (15) between the two (../shared/tools/gt_error.py does the same). Views are paired by name. Errors:
/// kBadInput with fewer than two common views or no usable point.
Result<CompareReport> CompareCameras(const RigCalibration& reference, const RigCalibration& estimate,
                                     const std::vector<ComparePoint>& points, CompareAlignment alignment);

/// Points spread over the volume that at least two views of the reference share: what CompareCameras is given when
/// nobody knows the object. A fixed lattice: the same cameras give the same points.
Result<std::vector<ComparePoint>> SpreadPoints(const RigCalibration& reference);

}  // namespace rigcal
