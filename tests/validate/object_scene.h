#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"
#include "core/validate/compare.h"

namespace rigcal::test {

enum class Motion { kTurntable, kHemisphere, kTwoCameraTurntable };

struct SceneOptions {
  Motion motion = Motion::kTurntable;
  int num_views = 24;
  int num_points = 700;
  double noise_px = 0.2;  ///< one coordinate of one feature
  double outlier_share = 0.03;
  double held_out_share = 0.15;
  std::uint64_t random_seed = 1;
};

/// True cameras, points on an ellipsoid seen by the cameras that face them, and what was measured of them.
struct ObjectScene {
  RigCalibration truth;
  std::vector<ComparePoint> points;
  TrackSet tracks;
};
ObjectScene MakeScene(const SceneOptions& options);

/// Tracks of given points under given cameras: noise, outliers (uniform within 8 px), held-out marks.
TrackSet MeasuredTracks(const RigCalibration& truth, const std::vector<ComparePoint>& points,
                        const SceneOptions& options);

/// How cameras bent by a projectivity reach the program.
enum class BentAs {
  kCamerasPerView,  ///< K [R | t] of every P H, with its skew: the pictures stay as they are
  kSharedCameras,   ///< the same with the skew dropped and the median intrinsics of each physical camera
};

/// `calibration` bent by a random projectivity near the identity, so strong that the mean error at `points` is
/// target_px after the best similarity. `affine_only` and `plane_only`: only these entries of the 4x4 matrix.
enum class BendEntries { kAll, kAffine, kPlaneAtInfinity };
RigCalibration Bent(const RigCalibration& calibration, const std::vector<ComparePoint>& points, double target_px,
                    BentAs as, BendEntries entries, std::uint64_t random_seed);

/// Mean error of the estimate at the points after the best similarity.
double ErrorPx(const RigCalibration& truth, const RigCalibration& estimate, const std::vector<ComparePoint>& points);

}  // namespace rigcal::test
