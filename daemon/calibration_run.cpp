#include "daemon/calibration_run.h"

#include <utility>

#include "config/patches_file.h"
#include "core/scene/holdout.h"
#include "daemon/refine_round.h"

namespace rigcal {
namespace {

/// Brings far-off cameras near enough for stereo, with plain features (DESIGN.md section 3, point 7).
Result<void> ApproachRig(const ImageSet& images, const RigCalibration& seed, const RefineOptions& options,
                         RunContext& context, RefineState& state) {
  const Result<TrackSet> tracks = context.Time("sparse", -1, [&](const Execution& execution) {
    return MatchSparse(images, state.calibration, SparseOptionsFor(state, options), execution);
  });
  if (!tracks) return Fail(tracks.error());
  if (tracks->tracks.empty()) return {};
  const Result<Adjustment> adjusted = context.Time("approach", -1, [&](const Execution& execution) {
    return Adjust(state.calibration, *tracks, state.expected_error_px, ApproachOptionsFor(state, seed, options),
                  execution);
  });
  if (!adjusted && adjusted.error().code == ErrorCode::kBadInput) return {};  // too few: stereo starts from the seed
  if (!adjusted) return Fail(adjusted.error());
  Approach(state, *adjusted, images, options);
  return {};
}

Result<ValidationReport> Judge(const ValidationInput& evidence, RunContext& context) {
  return context.Time("validate", -1, [&](const Execution& execution) { return Validate(evidence, execution); });
}

}  // namespace

Result<RefinedRig> RefineRig(const ImageSet& images, const RigCalibration& seed, const RefineOptions& options,
                             RunContext& context) {
  context.SetNumRounds(options.num_rounds);
  RefinedRig rig;
  Result<RefineState> state = BeginRefinement(images, seed, options, context, rig.report);
  if (!state) return Fail(state.error());

  if (WantsApproach(*state, options)) {
    auto approached = ApproachRig(images, seed, options, context, *state);
    if (!approached) return Fail(approached.error());
  }

  while (!Converged(*state, options)) {
    Result<std::vector<Patch>> patches = context.Time("stereo", state->round, [&](const Execution& execution) {
      return Reconstruct(images, state->calibration, StereoOptionsFor(*state), execution);
    });
    if (!patches) return Fail(patches.error());

    Result<TrackSet> tracks = context.Time("match", state->round, [&](const Execution& execution) {
      return Match(images, state->calibration, *patches, MatchOptionsFor(*state, options), execution);
    });
    if (!tracks) return Fail(tracks.error());
    HoldOut(*tracks, options.holdout_share, options.random_seed);

    Result<Adjustment> adjusted = context.Time("adjust", state->round, [&](const Execution& execution) {
      return Adjust(state->calibration, *tracks, state->expected_error_px, AdjustOptionsFor(*state, seed, options),
                    execution);
    });
    if (!adjusted && adjusted.error().code == ErrorCode::kBadInput) {
      // Nothing to adjust with is a finding, not a failure: the verdict names the views without support.
      rig.report.notes.push_back(adjusted.error().message);
      rig.tracks = std::move(*tracks);
      break;
    }
    if (!adjusted) return Fail(adjusted.error());

    FinishRound(*state, patches->size(), *adjusted, images, options, rig.report);
    rig.patches = std::move(*patches);
    rig.tracks = std::move(adjusted->tracks);
  }
  rig.calibration = state->calibration;
  rig.patch_colours_bgr = PatchColours(rig.patches, images, rig.calibration);

  Result<ValidationReport> validation =
      Judge(EvidenceFor(images, rig.calibration, rig.tracks, seed, state->initial_error_px, options), context);
  if (!validation) return Fail(validation.error());
  ReportOutcome(rig.calibration, rig.tracks, *validation, rig.report);
  FinishRig(*state, options, rig);
  return rig;
}

Result<RefinedRig> ValidateRig(const ImageSet& images, const RigCalibration& cameras,
                               const std::optional<RigCalibration>& prior, const RefineOptions& options,
                               RunContext& context) {
  RefinedRig rig;
  rig.calibration = cameras;
  Result<RefineState> state = BeginRefinement(images, cameras, options, context, rig.report);
  if (!state) return Fail(state.error());
  Result<std::vector<Patch>> patches = context.Time("stereo", -1, [&](const Execution& execution) {
    return Reconstruct(images, cameras, StereoOptionsFor(*state), execution);
  });
  if (!patches) return Fail(patches.error());
  Result<TrackSet> tracks = context.Time("match", -1, [&](const Execution& execution) {
    return Match(images, cameras, *patches, MatchOptionsFor(*state, options), execution);
  });
  if (!tracks) return Fail(tracks.error());
  HoldOut(*tracks, options.holdout_share, options.random_seed);

  Result<ValidationReport> validation =
      Judge(EvidenceFor(images, cameras, *tracks, prior, prior ? state->initial_error_px : 0.0, options), context);
  if (!validation) return Fail(validation.error());
  rig.patches = std::move(*patches);
  rig.patch_colours_bgr = PatchColours(rig.patches, images, cameras);
  rig.tracks = std::move(*tracks);
  ReportOutcome(rig.calibration, rig.tracks, *validation, rig.report);
  return rig;
}

}  // namespace rigcal
