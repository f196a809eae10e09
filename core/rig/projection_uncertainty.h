#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/rig/free_parameters.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

/// A point of the object and a view that sees it: where uncertainty is looked at.
struct ViewPoint {
  int view = 0;
  Eigen::Vector3d x_in_world;
};

/// Up to max_per_view points of each view's own tracks, evenly through their order; of all tracks for a view that
/// observes none.
std::vector<ViewPoint> ObjectViewPoints(const RigCalibration& calibration, const TrackSet& tracks, int max_per_view);

/// Stated uncertainty of object points in each picture: root mean square over the points of the 2-D distance, in
/// pixels, one sigma, from calibration.covariance, after the best similarity alignment of all views at once (the gauge
/// does not matter at the object; what is measured is what CompareCameras measures). With any pose held fixed (zero
/// rows) there is no gauge and nothing is aligned. 0 for views without points.
std::vector<double> ProjectionSigmaPx(const RigCalibration& calibration, std::span<const ViewPoint> points);

/// How weakly the features alone hold the cameras together: for the worst `count` directions of the free parameters,
/// the image motion (root mean square over the points, pixels) that one sigma of that direction means, largest first,
/// after the best similarity alignment. `feature_information` is FeatureInformation(): without any prior, so that
/// drifts that only priors keep in check show (DESIGN.md section 4).
std::vector<double> WeakestDirectionsPx(const RigCalibration& calibration, const FreeParameters& free,
                                        const Eigen::MatrixXd& feature_information, std::span<const ViewPoint> points,
                                        int count);

}  // namespace rigcal
