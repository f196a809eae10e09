#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/execution.h"
#include "core/rig/priors.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

enum class Verdict { kAccepted, kRejected, kInconclusive };

/// A check that failed: its number and its limit, in `unit`, for one view or for the whole.
struct Reason {
  std::string check;
  double value = 0;
  double limit = 0;
  std::string unit;
  std::optional<std::string> view;
  std::optional<std::string> camera;  ///< id, for what concerns one camera's intrinsics
};

/// What one view did, for the report (DESIGN.md section 4).
struct ViewFinding {
  std::string name;
  std::string camera;
  double moved_px = 0;  ///< mean shift of object points against the prior's cameras, in the picture
  Eigen::Vector2d direction = Eigen::Vector2d::Zero();  ///< unit mean shift in the picture (+x right, +y down)
  double sigma_px = 0;                                  ///< stated uncertainty of object points in this picture
  int num_features = 0;
  double residual_px = 0;
};

struct HoldoutError {
  std::optional<double> before_px;  ///< held-out tracks under the prior's cameras; nothing without a prior
  double after_px = 0;              ///< under the judged ones
  int num_tracks = 0;
};

struct ValidationReport {
  Verdict verdict = Verdict::kInconclusive;
  std::vector<Reason> reasons;  ///< empty exactly when accepted
  HoldoutError holdout;
  std::vector<ViewFinding> views;
};

/// The cameras to be judged and the evidence. Nothing tells which method made the cameras.
struct ValidationInput {
  RigCalibration calibration;              ///< judged; with covariance when there is one
  TrackSet tracks;                         ///< measured features, held-out tracks among them
  std::optional<RigCalibration> prior;     ///< the cameras of before (the seed), same views
  double expected_error_px = 0;            ///< Er of the prior; 0 when there is no prior
  std::vector<CameraPrior> camera_priors;  ///< one per camera of `calibration`; empty: defaults for a bare camera file
  std::vector<double> sharpness;           ///< per view, core/image/sharpness.h; empty: not judged, 0: cannot be told
};

/// The verdict on cameras (DESIGN.md section 4). Any check that speaks against the cameras rejects; what merely cannot
/// be told makes it inconclusive. The checks' limits stand in limits.h. With prior cameras their frame and names count:
/// views are paired by name. Without a single held-out track all tracks judge: the cameras have seen none of them.
/// Tracks from stereo and matching with the judged cameras themselves are fine: matching finds what the pictures show.
/// Errors: kCancelled.
Result<ValidationReport> Validate(const ValidationInput& input, const Execution& execution);

}  // namespace rigcal
