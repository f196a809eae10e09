#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/median.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"
#include "core/validate/compare.h"

namespace rigcal {

/// Where the camera without its distortion would see a feature; nothing beyond the fold of a strong distortion.
std::optional<Eigen::Vector2d> UndistortedPx(const Camera& camera, const Eigen::Vector2d& x_px);

/// What a feature's picture is off from where the other views of its track put it.
struct CrossResidual {
  int view = 0;
  double residual_px = 0;
};

/// For every feature: its distance from the track's point as triangulated by all *other* views (cross-validated; a
/// track of two features gives the distance to the common point), divided by what the noise of those views adds to it:
/// on the scale of one feature's own error, however short the baseline of the others. Features whose others see the
/// point from one and the same direction are left out. Views with excluded[view] do not take part.
std::vector<CrossResidual> CrossResiduals(const RigCalibration& calibration, const std::vector<Track>& tracks,
                                          const std::vector<bool>& excluded);

/// Mean of the values after each was cut at kWinsorRatio times the median: single gross outliers count little, a
/// general rise counts in full. 0 without values.
double RobustMean(std::vector<double> values);

/// The tracks kept to judge: the held-out ones, or all when none is marked (cameras from elsewhere have seen none);
/// at most max_tracks, evenly through their order.
std::vector<Track> TracksToJudgeBy(const TrackSet& tracks, int max_tracks);

/// Tracks with which every view has about features_per_view features, as far as there are that many. Fixed choice.
std::vector<Track> SpreadSubset(const TrackSet& tracks, int num_views, int features_per_view);

/// The tracks' points, triangulated with these cameras, with the views of their features.
std::vector<ComparePoint> ObjectPoints(const RigCalibration& calibration, const std::vector<Track>& tracks);

/// Number of features in each view.
std::vector<int> FeatureCounts(const std::vector<Track>& tracks, int num_views);

/// num_views x num_views: how many tracks two views share.
Eigen::MatrixXi SharedTracks(const std::vector<Track>& tracks, int num_views);

/// Other views by the angle between the optical axes, nearest first.
std::vector<int> NeighboursOf(const RigCalibration& calibration, int view);

/// Which physical camera each camera is: cameras of one hardware get the same number, counted from 0.
std::vector<int> PhysicalCameras(const RigCalibration& calibration);

}  // namespace rigcal
