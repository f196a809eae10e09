#include "daemon/drift_run.h"

#include <algorithm>
#include <utility>

#include "config/positioner_names.h"
#include "config/rig_views.h"
#include "core/rig/rig_prior.h"
#include "core/validate/evidence.h"
#include "daemon/calibration_run.h"
#include "daemon/rig_terms.h"

namespace rigcal {
namespace {

/// Pyramids as a refinement has them (daemon/cli/run_request.cpp): up to level 4, Er up to 31 px.
constexpr int kPyramidLevels = 5;
/// Width of a mount's prior during the check: wider than anything that stereo can follow (Er up to 31 px), narrow
/// enough to hold what no picture shows. 0.02 rad are 25 px at 1300 px of focal length.
constexpr double kReleasedRad = 0.02, kReleasedM = 0.02;
/// Points of the object per view that motions are measured on, as core/validate does.
constexpr int kPointsPerView = 50;

Result<LoadedImages> LoadNight(const NightRecording& night, const DriftOptions& options, RigCalibration& calibration,
                               RunContext& context) {
  ImageOptions images{.num_levels = kPyramidLevels, .masks = options.masks};
  images.sha256_by_image = night.recorded.sha256_by_image;
  return context.Time(
      "load", -1, [&](const Execution& execution) { return LoadImages(night.folder, calibration, images, execution); });
}

RefineOptions RefineOptionsFor(const RigViews& placed, const DriftOptions& options) {
  RefineOptions refine{.expected_error_px = options.expected_error_px, .random_seed = options.random_seed};
  for (const Camera& camera : placed.calibration.cameras) {
    refine.camera_priors.push_back({.principal_point_px = {camera.cx_px, camera.cy_px}});
  }
  refine.rig = RigTermsOf(placed);
  for (int c = 0; c < placed.calibration.NumCameras(); ++c) {
    if (refine.rig->prior.model.cam_from_mount[c]) LoosenMount(c, kReleasedRad, kReleasedM, refine.rig->prior);
  }
  return refine;
}

/// Cameras and mounts as they are; only the stops' small errors follow the pictures.
Result<RigCalibration> FitStops(const RigViews& placed, const TrackSet& tracks, RunContext& context) {
  AdjustOptions options{.intrinsics = IntrinsicsMode::kFixed, .estimate_covariance = false};
  options.noise.weight_by_covariance = true;
  options.rig = RigTermsOf(placed);
  options.rig->prior.covariance.joint.setZero();
  const std::vector<double> any_error_px(placed.calibration.views.size(), 1.0);  // for a report that nobody reads
  auto adjusted = context.Time("hold out", -1, [&](const Execution& execution) {
    return Adjust(placed.calibration, tracks, any_error_px, options, execution);
  });
  if (!adjusted) return Fail(adjusted.error());
  return std::move(adjusted->calibration);
}

/// Hold-out error of each camera; nothing for one without held-out features.
std::vector<std::optional<double>> HoldoutErrors(const RigCalibration& calibration, const TrackSet& tracks) {
  std::vector<Track> held_out;
  std::ranges::copy_if(tracks.tracks, std::back_inserter(held_out), &Track::held_out);
  std::vector<std::vector<double>> residuals(calibration.cameras.size());
  const std::vector<bool> none_excluded(calibration.views.size(), false);
  for (const CrossResidual& residual : CrossResiduals(calibration, held_out, none_excluded)) {
    residuals[calibration.views[residual.view].camera].push_back(residual.residual_px);
  }
  std::vector<std::optional<double>> errors;
  for (std::vector<double>& of_camera : residuals) {
    errors.push_back(of_camera.empty() ? std::nullopt : std::optional(RobustMean(std::move(of_camera))));
  }
  return errors;
}

void CountFeatures(const RigCalibration& calibration, const TrackSet& tracks, std::vector<CameraEvidence>& cameras) {
  for (const Track& track : tracks.tracks) {
    for (const Observation& o : track.observations) ++cameras[calibration.views[o.view].camera].num_features;
  }
}

std::optional<std::string> LastPictureAt(const Recording& recording) {
  std::optional<std::string> last;
  for (const RecordedView& view : recording.views) {
    if (view.taken_at && (!last || *view.taken_at > *last)) last = view.taken_at;
  }
  return last;
}

DriftInput InputWithoutFinding(const RigViews& placed, const DriftOptions& options) {
  const RigEstimate& rig = *placed.calibration.rig;
  DriftInput input{.in_force = {placed.calibration.cameras, rig.model, rig.covariance},
                   .released_rad = kReleasedRad,
                   .released_m = kReleasedM};
  input.placed = placed.calibration;
  input.found.cameras = placed.calibration.cameras;
  input.stops = placed.stops;
  input.stop_of_view = placed.stop_of_view;
  input.cameras.resize(placed.calibration.cameras.size());
  input.positioner_name = fmt::format("the {}", WordOf(kPositionerKinds, rig.model.positioner.kind));
  input.limits = options.limits;
  return input;
}

/// What the refinement showed. Errors: kCancelled.
Result<void> AddFinding(const RigViews& placed, const RefinedRig& refined, RunContext& context, DriftInput& input) {
  CountFeatures(placed.calibration, refined.tracks, input.cameras);
  input.slips = refined.slips;
  for (const std::string& sentence : refined.report.contradictions) {
    if (std::ranges::find(refined.slips, sentence) == refined.slips.end()) input.notes.push_back(sentence);
  }
  if (!refined.calibration.rig) return {};
  const auto as_it_is = FitStops(placed, refined.tracks, context);
  if (!as_it_is) return Fail(as_it_is.error());
  const auto before = HoldoutErrors(*as_it_is, refined.tracks);
  const auto after = HoldoutErrors(refined.calibration, refined.tracks);
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    input.cameras[c].before_px = before[c];
    input.cameras[c].after_px = after[c];
  }
  input.found = refined.calibration;
  input.points = ObjectViewPoints(placed.calibration, refined.tracks, kPointsPerView);
  return {};
}

}  // namespace

Result<DriftCheck> CheckDrift(const NightRecording& night, const CalibrationInForce& in_force,
                              const DriftOptions& options, RunContext& context) {
  const Recording& recording = night.recorded.recording;
  Result<RigViews> placed = PlaceRecording(in_force.calibration, in_force.name, recording, night.folder.string());
  if (!placed) return Fail(placed.error());
  const Result<LoadedImages> loaded = LoadNight(night, options, placed->calibration, context);
  if (!loaded) return Fail(loaded.error());

  DriftInput input = InputWithoutFinding(*placed, options);
  DriftCheck check;
  const auto refined = RefineRig(loaded->images, placed->calibration, RefineOptionsFor(*placed, options), context);
  if (refined) {
    if (auto added = AddFinding(*placed, *refined, context, input); !added) return Fail(added.error());
    check.refinement = refined->report;
  } else if (refined.error().code == ErrorCode::kBadInput) {
    input.notes.push_back(refined.error().message);
  } else {
    return Fail(refined.error());
  }
  check.report = {.finding = JudgeDrift(input),
                  .recording_id = recording.id,
                  .recorded_at = LastPictureAt(recording),
                  .calibration_sha256 = in_force.sha256,
                  .notes = check.refinement.notes};
  return check;
}

}  // namespace rigcal
