#include "daemon/refine_round.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/image/sharpness.h"
#include "core/rig/rig_axis.h"
#include "core/scene/expected_error.h"
#include "core/validate/compare.h"

namespace rigcal {
namespace {

/// Below this level stereo costs four times as much a level and gains nothing (DESIGN.md section 3, point 6).
constexpr int kFinestLevel = 2;
/// Shorter side of the smallest picture on which stereo can still find its way (DESIGN.md section 3, point 7: at 80 x
/// 60 pixels it starts poorly).
constexpr int kSmallestSidePx = 100;
/// Er from which on plain feature tracks are asked first. Below, stereo at the finest level finds its way alone.
constexpr double kApproachFromErrorPx = 4;
/// Plain features that a view must have for its Er to follow from their residuals.
constexpr int kMinApproachFeatures = 25;
/// Er is a bound (mean + 3 sigma, at least a pixel of the level), stereo searches around a mean. With 1 px instead of
/// the bound's 4 px, stereo on the plaster turntable found 1.6 times as many patches in a quarter of the time.
constexpr double kStereoErrorPx = 1;
/// Mean motion at the object between two rounds below which another round changes nothing that counts: the plaster
/// turntable, whose features are the noisiest, is equally far from the truth after 2, 3, 4 and 6 rounds (median of
/// four starts: 0.097, 0.098, 0.100, 0.104 px).
constexpr double kConvergedPx = 0.15;
constexpr int kMinRounds = 2;
/// Side of the matching window at full size. With the paper's 7 px the plaster turntable ends at 0.097 px, with 9 px at
/// 0.074 px, with 11 px at 0.083 px (four starts); textured and thin-parts sets do not care (0.013 and 0.011 px).
constexpr int kMatchWindowPx = 9;
/// See MeasurementNoise. On fountain-P11 (60,000 features a view) the mean residuals of regions of 384 x 342 pixels are
/// 0.01 to 0.02 px. Taken as independent, its features outvoted the seed by far and bent the vertical focal length by
/// 0.4 %, ninety times its stated sigma: 1.63 px off (mean truth error), with this 1.00 px.
constexpr double kSystematicSigmaPx = 0.015;
/// Points that the motion between two rounds is measured on.
constexpr std::size_t kNumMotionPoints = 500;
/// The paper's share of features kept by sub-sampling (section 3.1: ten to twenty percent).
constexpr double kPaperKeptShare = 0.15;

int CoarsestLevel(const ImageSet& images) {
  int coarsest = images.NumLevels() - 1;
  for (const ViewImages& view : images.views) {
    const cv::Size size = view.SizePx();
    while (coarsest > 0 && (std::min(size.width, size.height) >> coarsest) < kSmallestSidePx) --coarsest;
  }
  return coarsest;
}

int LevelFor(const ImageSet& images, const std::vector<double>& expected_error_px, RefineMethod method) {
  const double largest = *std::max_element(expected_error_px.begin(), expected_error_px.end());
  const int finest = method == RefineMethod::kPaper ? 0 : kFinestLevel;
  const int coarsest = CoarsestLevel(images);
  return std::clamp(PyramidLevel(largest), std::min(finest, coarsest), coarsest);
}

/// Mean motion of the pictures of the tracks' points between two rounds, after the best similarity.
double MotionPx(const RigCalibration& before, const Adjustment& adjustment) {
  const auto& tracks = adjustment.tracks.tracks;
  const std::size_t step = std::max<std::size_t>(1, tracks.size() / kNumMotionPoints);
  std::vector<ComparePoint> points;
  for (std::size_t i = 0; i < tracks.size(); i += step) {
    ComparePoint point{.x_in_world = tracks[i].x_in_world};
    for (const Observation& o : tracks[i].observations) point.views.push_back(o.view);
    points.push_back(point);
  }
  const auto compared = CompareCameras(adjustment.calibration, before, points, CompareAlignment::kSimilarity);
  return compared ? compared->mean_px : std::numeric_limits<double>::infinity();
}

void Advance(RefineState& state, const Adjustment& adjustment, const ImageSet& images, const RefineOptions& options) {
  state.moved_px = MotionPx(state.calibration, adjustment);
  state.calibration = adjustment.calibration;
  state.rig = adjustment.rig;
  state.expected_error_px = adjustment.report.expected_error_px;
  // L is fixed in the paper; here it may fall (DESIGN.md section 3, point 6) but never rises.
  if (options.method == RefineMethod::kRigcal) {
    state.level = std::min(state.level, LevelFor(images, state.expected_error_px, options.method));
  }
  ++state.round;
}

/// With fixed cameras the others alone count: they were fixed because they are right.
double ExpectedErrorFrom(const ExpectedErrorEstimate& estimate, const std::vector<bool>& fixed_views) {
  if (fixed_views.empty()) return estimate.overall_px;
  double largest_px = 0;
  for (std::size_t v = 0; v < fixed_views.size(); ++v) {
    if (!fixed_views[v]) largest_px = std::max(largest_px, estimate.per_view_px[v]);
  }
  return largest_px;
}

}  // namespace

Result<RefineState> BeginRefinement(const ImageSet& images, const RigCalibration& seed, const RefineOptions& options,
                                    RunContext& context, RunReport& report) {
  RefineState state{.calibration = seed};
  state.calibration.covariance.reset();
  state.calibration.rig.reset();
  if (options.expected_error_px) {
    state.initial_error_px = *options.expected_error_px;
  } else {
    const auto estimate = context.Time(
        "estimate", -1, [&](const Execution& execution) { return EstimateExpectedError(images, seed, execution); });
    if (!estimate) return Fail(estimate.error());
    state.initial_error_px = ExpectedErrorFrom(*estimate, options.fixed_views);
    report.notes.push_back(fmt::format("expected error estimated from {} feature matches: {:.2f} px",
                                       estimate->num_matches, state.initial_error_px));
  }
  state.expected_error_px.assign(seed.views.size(), state.initial_error_px);
  state.level = LevelFor(images, state.expected_error_px, options.method);
  report.method = options.method == RefineMethod::kPaper ? "paper" : "rigcal";
  report.expected_error_px = state.initial_error_px;
  report.expected_error_estimated = !options.expected_error_px;
  report.level = state.level;
  return state;
}

StereoOptions StereoOptionsFor(const RefineState& state) {
  StereoOptions stereo;
  stereo.level = state.level;
  stereo.expected_error_px = state.expected_error_px;
  const double finest_px = std::ldexp(1.0, state.level);
  for (double& error_px : stereo.expected_error_px) {
    if (error_px <= finest_px && error_px < state.initial_error_px) error_px = kStereoErrorPx;
  }
  return stereo;
}

MatchOptions MatchOptionsFor(const RefineState& state, const RefineOptions& options) {
  MatchOptions match;
  match.level = state.level;
  if (options.method == RefineMethod::kRigcal) match.window_px = kMatchWindowPx;
  match.expected_error_px = state.expected_error_px;
  match.random_seed = DeriveSeed(options.random_seed, static_cast<std::uint64_t>(state.round));
  if (options.method == RefineMethod::kPaper) {
    match.min_ncc = 0;
    match.kept_share = kPaperKeptShare;
    match.min_features_per_view = 0;
  }
  return match;
}

AdjustOptions AdjustOptionsFor(const RefineState& state, const RigCalibration& seed, const RefineOptions& options) {
  AdjustOptions adjust;
  adjust.estimate_covariance = state.round + 1 >= std::min(kMinRounds, options.num_rounds);
  if (options.method == RefineMethod::kPaper) {
    adjust.paper = true;
    adjust.intrinsics = IntrinsicsMode::kPerView;
    adjust.cauchy_scale_px = 0;
    adjust.min_expected_error_px = 0;
    adjust.min_features_per_view = 0;
    return adjust;
  }
  adjust.intrinsics = options.intrinsics;
  adjust.min_expected_error_px = std::ldexp(1.0, state.level);
  adjust.noise.weight_by_covariance = true;
  adjust.noise.systematic_sigma_px = kSystematicSigmaPx;
  if (options.rig) {
    adjust.rig = options.rig;
    if (state.rig) adjust.rig->start = state.rig->state;
    return adjust;
  }
  adjust.camera_priors = options.camera_priors;
  adjust.seed_prior = SeedPrior{.seed = seed, .expected_error_px = state.initial_error_px};
  adjust.fixed_views = options.fixed_views;
  return adjust;
}

bool WantsApproach(const RefineState& state, const RefineOptions& options) {
  return options.method == RefineMethod::kRigcal && state.initial_error_px >= kApproachFromErrorPx;
}

SparseMatchOptions SparseOptionsFor(const RefineState& state, const RefineOptions& options) {
  SparseMatchOptions sparse;
  sparse.expected_error_px = state.expected_error_px;
  sparse.random_seed = options.random_seed;
  return sparse;
}

AdjustOptions ApproachOptionsFor(const RefineState& state, const RigCalibration& seed, const RefineOptions& options) {
  AdjustOptions adjust = AdjustOptionsFor(state, seed, options);
  adjust.min_expected_error_px = std::ldexp(1.0, std::min(state.level, kFinestLevel));
  adjust.min_features_per_view = kMinApproachFeatures;
  adjust.estimate_covariance = false;
  return adjust;
}

void Approach(RefineState& state, const Adjustment& adjustment, const ImageSet& images, const RefineOptions& options) {
  Advance(state, adjustment, images, options);
  state.round = 0;
}

bool Converged(const RefineState& state, const RefineOptions& options) {
  if (state.round >= options.num_rounds) return true;
  return options.method == RefineMethod::kRigcal && state.round >= kMinRounds && state.moved_px < kConvergedPx;
}

void FinishRound(RefineState& state, std::size_t num_patches, const Adjustment& adjustment, const ImageSet& images,
                 const RefineOptions& options, RunReport& report) {
  RoundReport round{.level = state.level,
                    .num_patches = static_cast<int>(num_patches),
                    .num_tracks = adjustment.report.num_tracks,
                    .num_observations = adjustment.report.num_observations,
                    .reprojection_mean_px = adjustment.report.reprojection_mean_px,
                    .reprojection_std_px = adjustment.report.reprojection_std_px,
                    .expected_error_px = state.expected_error_px};
  Advance(state, adjustment, images, options);
  round.moved_px = state.moved_px;
  report.rounds.push_back(std::move(round));
}

ValidationInput EvidenceFor(const ImageSet& images, const RigCalibration& calibration, const TrackSet& tracks,
                            const std::optional<RigCalibration>& prior, double expected_error_px,
                            const RefineOptions& options) {
  ValidationInput input{.calibration = calibration,
                        .tracks = tracks,
                        .prior = prior,
                        .expected_error_px = expected_error_px,
                        .camera_priors = options.camera_priors};
  for (const ViewImages& view : images.views) input.sharpness.push_back(Sharpness(view.gray[0], view.mask));
  return input;
}

void FinishRig(const RefineState& state, const RefineOptions& options, RefinedRig& rig) {
  if (!options.rig || !state.rig) return;
  RigFit fit{.positioner = state.rig->state.model.positioner,
             .stop_errors = state.rig->state.stop_errors,
             .stop_error_sigma = state.rig->stop_error_sigma};
  for (const StopPosition& stop : options.rig->stops) fit.stop_ids.push_back(stop.id);
  if (rig.calibration.rig) {
    rig.calibration.rig->axes = options.rig->axes;
    fit.axis = AxisOf(*rig.calibration.rig);
  }
  rig.report.rig = std::move(fit);
  rig.report.contradictions = state.rig->contradictions;
  rig.slips = state.rig->slips;
  ValidationReport& validation = rig.report.validation;
  if (!state.rig->scale_is_lost) return;
  if (validation.verdict == Verdict::kAccepted) validation.verdict = Verdict::kInconclusive;
  validation.reasons.push_back(
      {.check = "cameras that kept their place in the rig", .value = 0, .limit = 1, .unit = ""});
}

void ReportOutcome(const RigCalibration& calibration, const TrackSet& tracks, const ValidationReport& validation,
                   RunReport& report) {
  report.validation = validation;
  report.views_per_track.assign(calibration.views.size() + 1, 0);
  for (const Track& track : tracks.tracks) ++report.views_per_track[track.observations.size()];
  report.cameras.clear();
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    CameraReport camera{.camera = calibration.cameras[c]};
    if (calibration.covariance) camera.sigma = calibration.covariance->IntrinsicsSigma(c);
    report.cameras.push_back(camera);
  }
}

}  // namespace rigcal
