#pragma once

#include <vector>

#include "core/adjust/adjust.h"
#include "core/match/match.h"
#include "core/match/match_sparse.h"
#include "core/mvs/reconstruct.h"
#include "daemon/calibration_run.h"

namespace rigcal {

/// Where the rounds stand: the cameras so far and how wrong each view may be.
struct RefineState {
  RigCalibration calibration;
  std::optional<RigOutcome> rig;          ///< with RefineOptions::rig, after an adjustment
  double initial_error_px = 0;            ///< Er of the run
  std::vector<double> expected_error_px;  ///< Er of each view
  int round = 0;
  int level = 0;        ///< of the round at hand
  double moved_px = 0;  ///< mean motion at the object by the last adjustment
};

/// The state before the first round, with the given or the estimated Er; the report says which.
Result<RefineState> BeginRefinement(const ImageSet& images, const RigCalibration& seed, const RefineOptions& options,
                                    RunContext& context, RunReport& report);

/// The options of each stage in the round at hand.
StereoOptions StereoOptionsFor(const RefineState& state);
MatchOptions MatchOptionsFor(const RefineState& state, const RefineOptions& options);
AdjustOptions AdjustOptionsFor(const RefineState& state, const RigCalibration& seed, const RefineOptions& options);

/// Whether plain feature tracks are asked first (DESIGN.md section 3, point 7): they do not care how far off the
/// cameras are, and what they mend makes stereo's search narrow.
bool WantsApproach(const RefineState& state, const RefineOptions& options);
SparseMatchOptions SparseOptionsFor(const RefineState& state, const RefineOptions& options);

AdjustOptions ApproachOptionsFor(const RefineState& state, const RigCalibration& seed, const RefineOptions& options);

/// Takes over the cameras that plain feature tracks gave. Views with little support keep their Er.
void Approach(RefineState& state, const Adjustment& adjustment, const ImageSet& images, const RefineOptions& options);

/// Adds a finished round to the report, takes over its cameras and new Er, and chooses the level of the next.
void FinishRound(RefineState& state, std::size_t num_patches, const Adjustment& adjustment, const ImageSet& images,
                 const RefineOptions& options, RunReport& report);

/// Whether the rounds are over: all done, or (kRigcal) the last one moved nothing that counts.
bool Converged(const RefineState& state, const RefineOptions& options);

/// What the verdict is drawn from.
ValidationInput EvidenceFor(const ImageSet& images, const RigCalibration& calibration, const TrackSet& tracks,
                            const std::optional<RigCalibration>& prior, double expected_error_px,
                            const RefineOptions& options);

/// Completes the report from the last round's tracks, the cameras with their sigma, and the verdict.
void ReportOutcome(const RigCalibration& calibration, const TrackSet& tracks, const ValidationReport& validation,
                   RunReport& report);

/// What was found of the rig, when there is one, goes into the report and into the calibration. A run that lost the
/// scale cannot be accepted.
void FinishRig(const RefineState& state, const RefineOptions& options, RefinedRig& rig);

}  // namespace rigcal
