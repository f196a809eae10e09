#pragma once

#include <vector>

#include "core/base/execution.h"
#include "core/validate/validate.h"

namespace rigcal {

/// A failed check and what it makes of the verdict: kRejected or kInconclusive.
struct Objection {
  Verdict verdict;
  Reason reason;
};

/// What all checks look at, made once.
struct JudgedCase {
  const ValidationInput& input;
  std::vector<CameraPrior> camera_priors;  ///< one per camera, defaults filled in
  std::vector<Track> judging_tracks;       ///< held out, or all of them; at most kMaxJudgingTracks
  std::vector<int> num_features;           ///< per view, of all tracks
  std::vector<bool> excluded;              ///< views found unusable so far: they do not spoil the judgement of others
  std::vector<Objection> objections;
  ValidationReport report;  ///< holdout and views, filled by the checks

  [[nodiscard]] const std::string& NameOf(int view) const { return input.calibration.views[view].name; }
  void Object(Verdict verdict, Reason reason) { objections.push_back({verdict, std::move(reason)}); }
};

inline constexpr int kMaxJudgingTracks = 3000;  ///< more only cost time

/// Fills in the defaults: a bare camera file has aspect 1 +- 0.5 % and a principal point near the picture's centre.
std::vector<CameraPrior> CompletePriors(const ValidationInput& input);

/// Are the cameras numbers at all? False: nothing else can be checked.
bool CheckFinite(JudgedCase* judged);

// Evidence: tracks, support of each view, connections between views, sharpness of the pictures (inconclusive).
void CheckSupport(JudgedCase* judged);
void CheckConnections(JudgedCase* judged);
void CheckSharpness(JudgedCase* judged);

// Errors in the picture: single views, hold-out before and after, epipolar distance (rejected).
void CheckViewResiduals(JudgedCase* judged);
void CheckHoldout(JudgedCase* judged);
void CheckEpipolar(JudgedCase* judged);

// Against what is known: distance from the prior's cameras, aspect, principal point, skew, spread (rejected).
void CheckDistanceFromPrior(JudgedCase* judged);
void CheckIntrinsics(JudgedCase* judged);

/// Self-consistency (rejected): what hold-out and epipolar errors cannot see. Errors: kCancelled.
Result<void> CheckBend(JudgedCase* judged, const Execution& execution);

/// Stated uncertainty (inconclusive).
void CheckSigma(JudgedCase* judged);

}  // namespace rigcal
