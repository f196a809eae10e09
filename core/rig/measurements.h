#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

/// The point that a track's observations see with these cameras, by all of them alike. Nothing when it cannot be told.
std::optional<Eigen::Vector3d> TriangulateTrack(const RigCalibration& calibration, const Track& track);

/// How uncertain a feature is before anything is known of the fit.
struct MeasurementNoise {
  double observation_sigma_px = 0.3;  ///< one coordinate of one patch feature (DESIGN.md section 3, point 1)
  double sparse_sigma_px = 0.6;       ///< of a sparse feature: its own detector's scatter, twice a patch's
  /// Shape and size of each feature's uncertainty from Observation::covariance_px2, scaled so that the median feature
  /// has observation_sigma_px (DESIGN.md section 3, point 8); identity counts as unknown and gets the plain sigma.
  bool weight_by_covariance = false;
  /// Error that a view's features of one source share, so that more of them do not average it out (distortion that the
  /// camera file leaves out, surfaces that are not flat, JPEG): together they are worth no more than one measurement
  /// this good. 0: all errors are independent.
  double systematic_sigma_px = 0;
};

/// One feature, ready for least squares: whitening * (projection - x_px) has unit variance.
struct Measurement {
  int point = 0;  ///< index into MeasurementSet::x_in_world
  int view = 0;
  Eigen::Vector2d x_px;
  Eigen::Matrix2d whitening;
  double weight = 1;  ///< in (0, 1]: how much it counts, see MeasurementNoise::systematic_sigma_px
};

/// What an adjustment works on: the tracks without the held-out ones, flattened, ordered by point.
struct MeasurementSet {
  std::vector<Eigen::Vector3d> x_in_world;
  std::vector<int> track;  ///< per point: its index in the TrackSet
  std::vector<Measurement> items;
};

/// Leaves out held-out tracks, observations that are not finite or whose point does not lie in front of the camera, and
/// tracks that then have fewer than two.
MeasurementSet MeasurementsOf(const RigCalibration& calibration, const TrackSet& tracks, const MeasurementNoise& noise);

}  // namespace rigcal
