#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/rig/priors.h"
#include "core/rig/projection_uncertainty.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/rig_devices.h"

namespace rigcal {

/// kDrifting: something moved against the rest. kFailed: the rig does not do what its calibration says beyond that.
/// kInconclusive: the recording is too weak to tell.
enum class DriftState { kOk, kDrifting, kFailed, kInconclusive };

struct DriftLimits {
  double drift_px = kDriftLimitPx;  ///< motion at the object beyond which a camera drifts
  /// A sigma above drift_px over this is too large to tell: three sigma on either side of the limit.
  double sigmas = 3;
  /// Motion beyond which the calibration is of no use: the Er from which on stereo needs help
  /// (daemon/refine_round.cpp).
  double failed_px = 4;
  /// Hold-out error that no calibration of this rig explains (core/validate/limits.h, kMaxHoldoutPx).
  double holdout_px = 1.0;
  /// After the refinement it may exceed the one before by this share and so many pixels (core/validate/limits.h).
  double holdout_growth = 1.1, holdout_growth_px = 0.05;
  /// Features of one camera; three views as core/validate wants them.
  int min_features = 100;
};

/// What a camera's pictures of the night showed.
struct CameraEvidence {
  int num_features = 0;
  /// Hold-out error, same tracks: under the calibration in force, the stops' small errors fitted; and as refined.
  /// Nothing: no held-out track.
  std::optional<double> before_px, after_px;
};

struct DriftInput {
  RigPrior in_force;  ///< as the calibration in force states it
  /// What each mount was let free by, independently of the others, in the adjustment that gave `found`: its prior was
  /// in_force.covariance with the squares of these added.
  double released_rad = 0, released_m = 0;
  /// Refined from the night's recording, with rig and its covariance; same cameras. Without rig: nothing could be
  /// adjusted.
  RigCalibration found;
  /// The night's views as in_force places them at its stops.
  RigCalibration placed;
  std::vector<StopPosition> stops;
  std::vector<int> stop_of_view;
  std::vector<ViewPoint> points;                  ///< of the object, in the views of `placed`
  std::vector<CameraEvidence> cameras;            ///< per camera
  std::vector<std::string> slips;                 ///< a sentence for each stop where the positioner slipped
  std::vector<std::string> notes;                 ///< other sentences that a person should see
  std::string positioner_name = "the turntable";  ///< in sentences
  DriftLimits limits;
};

struct DriftReason {
  std::string check;
  double value = 0, limit = 0;
  std::string unit;
  std::optional<std::string> camera;
};

/// How the pictures of object points moved, from the calibration in force to the night.
struct PictureMotion {
  double moved_px = 0;                                       ///< mean length
  double sigma_px = 0;                                       ///< root mean square over the points, 2-D
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();        ///< mean (+x right, +y down)
  Eigen::Vector2d shift_sigma_px = Eigen::Vector2d::Zero();  ///< of each component of the mean
};

/// One camera against the others that did not move, the errors of the calibration in force counted in its sigma.
struct CameraDrift {
  std::string camera;  ///< id
  PictureMotion motion;
  double chi_square = 0;  ///< how much better its motion explains the night: of six numbers
  bool moved = false;     ///< beyond the limit and no chance
  CameraEvidence evidence;
};

struct DriftFinding {
  DriftState state = DriftState::kInconclusive;
  double limit_px = 0;
  std::vector<CameraDrift> cameras;  ///< those with pictures and a place in the rig
  /// All cameras together against the positioner, or it against them. Nothing with fewer than three cameras.
  std::optional<CameraDrift> together;
  std::vector<std::string> suspects;   ///< ids of cameras that moved, or one of which did
  bool which_is_told = false;          ///< the suspects are those that moved
  std::vector<DriftReason> reasons;    ///< empty exactly when ok
  std::vector<std::string> sentences;  ///< for people; the first says it all
};

/// Which camera moved since the calibration in force was made, by how much, which way, and whether that counts
/// (issue 5, drift check). A camera's motion is that of its mount against all others, which stay where the calibration
/// in force has them to its covariance; what moved most is found first and the others are judged beside it. A motion
/// that all cameras share is one of the positioner (not looked for beside a camera that moved beyond failed_px);
/// motions that no picture can show (the object stands elsewhere) are none. One camera's motion is what is left after
/// the best similarity of the object. With fewer than three cameras, or when as many as half of them moved, it cannot
/// be told which. Pure: same in, same out.
DriftFinding JudgeDrift(const DriftInput& input);

}  // namespace rigcal
