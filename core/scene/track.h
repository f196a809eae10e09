#pragma once

#include <Eigen/Core>
#include <vector>

namespace rigcal {

/// One place in one picture where a track was found.
struct Observation {
  int view = 0;
  /// In the original picture (distorted), full size, (0,0) = centre of the first pixel.
  Eigen::Vector2d x_px = Eigen::Vector2d::Zero();
  /// Of the feature's own fit; identity: unknown.
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
  float ncc = 0;  ///< with the reference feature; 1 for the reference itself
};

enum class TrackSource { kPatch, kSparse };

/// Pictures of one point of the surface.
struct Track {
  Eigen::Vector3d x_in_world = Eigen::Vector3d::Zero();
  std::vector<Observation> observations;  ///< at most one per view; [0] is the reference feature for kPatch
  TrackSource source = TrackSource::kPatch;
  bool held_out = false;  ///< not seen by the adjustment, kept to judge it (DESIGN.md section 4)
};

struct TrackSet {
  std::vector<Track> tracks;
};

}  // namespace rigcal
