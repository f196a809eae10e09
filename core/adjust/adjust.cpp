#include "core/adjust/adjust.h"

#include <algorithm>
#include <cmath>

#include "core/adjust/bundle.h"
#include "core/adjust/fit_quality.h"
#include "core/adjust/let_go.h"
#include "core/adjust/posterior.h"
#include "core/adjust/round_report.h"
#include "core/base/ensure.h"
#include "core/rig/gauge.h"
#include "core/rig/seed_anchors.h"

namespace rigcal {
namespace {

/// The first solution only has to tell right features from wrong ones. From far off, full Gauss-Newton steps overshoot:
/// Ceres' own radius.
constexpr BundleLimits kFirstLimits{0, 15, 1e-3, 1e4};
/// What is left after 3e-5 are single points between two features of theirs: on rendered rings and hemispheres the
/// truth error was the same to 0.001 px with 1e-7, at three times the cost. The directions that matter most (scale
/// along an axis, focal length) are a million times weaker than the strong ones, so the radius must not make it creep
/// along them.
constexpr BundleLimits kFinalLimits{0, 30, 3e-5, 1e6};
/// Plain least squares with 11 free parameters a view creeps along its 15-parameter gauge: stop in the end. Tolerance
/// and radius are Ceres' own.
constexpr BundleLimits kPaperLimits{0, 100, 1e-6, 1e4};

bool IsHeld(const AdjustOptions& options, int view) {
  return !options.fixed_views.empty() && options.fixed_views[view];
}

/// With a rig the lens is adjusted as far as the seed left it uncertain, distortion included.
void FreeWhatThePriorDoes(const RigPrior& prior, int camera, std::array<bool, kNumIntrinsics>& intrinsics) {
  for (int k = 0; k < kNumIntrinsics; ++k) {
    const int row = RigCovariance::IntrinsicsRow(camera) + k;
    intrinsics[k] = prior.covariance.joint(row, row) > 0;
  }
}

FreeParameters ChooseFree(const RigCalibration& start, const AdjustOptions& options) {
  FreeParameters free = AllPinholeParameters(start);
  for (int camera = 0; camera < start.NumCameras(); ++camera) {
    auto& intrinsics = free.intrinsics[camera];
    intrinsics[kSkew] = options.paper;
    for (const int k : {kK1, kK2, kP1, kP2, kK3}) intrinsics[k] = options.refine_distortion && !options.paper;
    if (options.rig) FreeWhatThePriorDoes(options.rig->prior, camera, intrinsics);
    if (options.intrinsics == IntrinsicsMode::kFixed) intrinsics.fill(false);
  }
  for (int view = 0; view < start.NumViews(); ++view) {
    if (!IsHeld(options, view)) continue;
    free.poses[view] = false;
    free.intrinsics[start.views[view].camera].fill(false);
  }
  return free;
}

void EnsurePromises(const RigCalibration& start, const std::vector<double>& expected_error_px,
                    const AdjustOptions& options) {
  const std::size_t num_views = start.views.size(), num_cameras = start.cameras.size();
  Ensure(expected_error_px.size() == num_views, "one expected error per view");
  Ensure(options.fixed_views.empty() || options.fixed_views.size() == num_views, "one fixed flag per view");
  Ensure(options.camera_priors.empty() || options.camera_priors.size() == num_cameras, "one prior per camera");
  Ensure(!options.seed_prior || options.seed_prior->seed.views.size() == num_views, "the seed has the same views");
  Ensure(!options.rig || (options.rig->stop_of_view.size() == num_views && options.fixed_views.empty()),
         "with a rig every view has a stop and none is fixed");
  Ensure(!options.rig || options.rig->prior.cameras.size() == num_cameras, "the rig has the same cameras");
  const bool own_cameras = options.paper || options.intrinsics == IntrinsicsMode::kPerView;
  Ensure(!own_cameras || num_cameras == num_views, "intrinsics per view need one camera per view");
}

/// Every track's point as these cameras see it, where that is nearer to its features than the point it came with.
TrackSet Retriangulated(const RigCalibration& calibration, const TrackSet& tracks) {
  const auto error_of = [&calibration](const Track& track, const Eigen::Vector3d& x_in_world) {
    std::vector<double> errors_px;
    for (const Observation& o : track.observations) {
      const auto x_px = Project(calibration.CameraOf(o.view), calibration.views[o.view].cam_from_world * x_in_world);
      errors_px.push_back(x_px ? (*x_px - o.x_px).norm() : std::numeric_limits<double>::infinity());
    }
    return Median(std::move(errors_px));  // one wrong feature shall not decide
  };
  TrackSet out = tracks;
  for (Track& track : out.tracks) {
    const auto x_in_world = TriangulateTrack(calibration, track);
    const bool better = x_in_world && !(error_of(track, *x_in_world) > error_of(track, track.x_in_world));
    if (better || (x_in_world && track.held_out)) track.x_in_world = *x_in_world;
  }
  return out;
}

BundleTerms TermsOf(const RigCalibration& start, const TrackSet& tracks, const AdjustOptions& options) {
  BundleTerms terms;
  terms.free = ChooseFree(start, options);
  if (options.paper) return terms;
  terms.rig = options.rig;
  if (terms.rig) return terms;
  terms.camera_priors = options.camera_priors;
  if (!options.seed_prior) return terms;
  terms.anchor_sigma_px = options.seed_prior->expected_error_px;
  Ensure(terms.anchor_sigma_px > 0, "the seed's expected error must be positive");
  terms.anchors = ChooseSeedAnchors(*options.seed_prior, tracks);
  std::erase_if(terms.anchors, [&start](const SeedAnchor& a) {
    return !((start.views[a.view].cam_from_world * a.x_in_world).z() > 0);
  });
  return terms;
}

/// A view that nothing determines stays where it is: fewer than 3 features (6 numbers for its 6) and no anchor.
void HoldUndetermined(const MeasurementSet& measurements, BundleTerms& terms) {
  constexpr int kMinFeatures = 3;
  std::vector<int> support(terms.free.poses.size(), 0);
  for (const Measurement& m : measurements.items) ++support[m.view];
  for (const SeedAnchor& a : terms.anchors) support[a.view] += kMinFeatures;
  for (std::size_t v = 0; v < support.size(); ++v) {
    if (support[v] < kMinFeatures) terms.free.poses[v] = false;
  }
}

/// How far off the features of the view that is farthest off are (median): a rig moves many views at once, and the
/// features of a camera that was bumped must not pass for outliers.
double WidestView(const FitResiduals& residuals, const MeasurementSet& measurements, int num_views) {
  constexpr std::size_t kLeastFeatures = 25;  // a single wrong one shall not decide
  std::vector<std::vector<double>> by_view(static_cast<std::size_t>(num_views));
  for (std::size_t i = 0; i < measurements.items.size(); ++i) {
    by_view[static_cast<std::size_t>(measurements.items[i].view)].push_back(residuals.sigmas[i]);
  }
  double widest = 0;
  for (std::vector<double>& view : by_view) {
    if (view.size() >= kLeastFeatures) widest = std::max(widest, Median(std::move(view)));
  }
  return widest;
}

/// Solves, drops what is grossly wrong (and lets go of the parts of a rig that are elsewhere), solves again. The loss
/// of the first solution is as wide as the cameras are off: a narrow one would take right features of a wrong view for
/// outliers.
Result<int> SolveRobustly(const AdjustOptions& options, const Execution& execution, BundleTerms& terms,
                          BundleUnknowns& unknowns, RigOutcome& outcome) {
  const RigCalibration& calibration = unknowns.calibration;
  MeasurementSet& measurements = unknowns.measurements;
  const double final_scale = options.cauchy_scale_px / options.noise.observation_sigma_px;
  const FitResiduals before = ResidualsOf(calibration, measurements);
  const double first_scale = std::max(
      final_scale, terms.rig ? WidestView(before, measurements, calibration.NumViews()) : Median(before.sigmas));
  BundleLimits first_limits = kFirstLimits, final_limits = kFinalLimits;
  first_limits.cauchy_scale = first_scale, final_limits.cauchy_scale = final_scale;
  int iterations = 0;
  LetGo let_go;
  do {
    const Result<int> first = SolveBundle(terms, first_limits, execution, unknowns);
    if (!first) return first;
    iterations += *first;
  } while (terms.rig && LetGoOfWorst(unknowns, options.contradiction_sigmas, *terms.rig, let_go));
  execution.Report(0.5);
  DropGrossErrors(ResidualsOf(calibration, measurements), final_scale, calibration.NumViews(), measurements);
  if (measurements.items.empty()) return Fail(ErrorCode::kBadInput, "bundle adjustment: no two features agree");
  do {
    const Result<int> last = SolveBundle(terms, final_limits, execution, unknowns);
    if (!last) return last;
    iterations += *last;
  } while (terms.rig && LetGoOfWorst(unknowns, options.contradiction_sigmas, *terms.rig, let_go));
  if (terms.rig) {
    outcome.contradictions = SentencesOf(let_go, options.contradiction_sigmas, unknowns, *options.rig);
    outcome.slips = SlipSentences(let_go, options.contradiction_sigmas, unknowns, *options.rig);
    outcome.scale_is_lost = ScaleIsLost(let_go, unknowns);
  }
  return iterations;
}

/// What the features determine but the points; a rig has far fewer than six for each view.
int NumCameraParameters(const BundleTerms& terms) {
  if (!terms.rig) return RowsOf(terms.free).count;
  auto count = static_cast<int>(terms.rig->prior.FreeRows().size());
  for (const StopError& sigma : terms.rig->stop_error_sigma) count += static_cast<int>((sigma.array() > 0).count());
  return count;
}

void MoveToFrame(const Similarity3d& new_from_old, RigCalibration& calibration, MeasurementSet& measurements) {
  calibration = InFrame(calibration, new_from_old);
  for (Eigen::Vector3d& x_in_world : measurements.x_in_world) x_in_world = new_from_old * x_in_world;
}

/// The refined points and what is left of their features; held-out tracks as they are, to be triangulated.
TrackSet TracksAfter(const TrackSet& before, const MeasurementSet& measurements) {
  std::vector<std::vector<int>> views(before.tracks.size());
  std::vector<int> point(before.tracks.size(), -1);
  for (const Measurement& m : measurements.items) {
    views[measurements.track[m.point]].push_back(m.view);
    point[measurements.track[m.point]] = m.point;
  }
  TrackSet after;
  for (std::size_t t = 0; t < before.tracks.size(); ++t) {
    if (!before.tracks[t].held_out && point[t] < 0) continue;
    Track& track = after.tracks.emplace_back(before.tracks[t]);
    if (track.held_out) continue;
    track.x_in_world = measurements.x_in_world[point[t]];
    std::erase_if(track.observations, [&kept = views[t]](const Observation& o) {
      return std::find(kept.begin(), kept.end(), o.view) == kept.end();
    });
  }
  return after;
}

void TriangulateHeldOut(const RigCalibration& calibration, TrackSet& tracks) {
  for (Track& track : tracks.tracks) {
    if (!track.held_out) continue;
    if (const auto x_in_world = TriangulateTrack(calibration, track)) track.x_in_world = *x_in_world;
  }
}

}  // namespace

Result<Adjustment> Adjust(const RigCalibration& start, const TrackSet& tracks,
                          const std::vector<double>& expected_error_px, const AdjustOptions& options,
                          const Execution& execution) {
  EnsurePromises(start, expected_error_px, options);
  if (execution.Stopped()) return Cancelled("bundle adjustment");
  BundleUnknowns unknowns{.calibration = start,
                          .measurements = MeasurementsOf(start, Retriangulated(start, tracks), options.noise)};
  unknowns.calibration.covariance.reset();
  unknowns.calibration.rig.reset();
  if (options.rig) unknowns.rig = options.rig->start;
  const int num_offered = static_cast<int>(unknowns.measurements.items.size());
  const int num_offered_tracks = static_cast<int>(unknowns.measurements.x_in_world.size());
  BundleTerms terms = TermsOf(start, tracks, options);
  if (!terms.rig) HoldUndetermined(unknowns.measurements, terms);
  if (num_offered == 0 || RowsOf(terms.free).count == 0) {
    return Fail(ErrorCode::kBadInput, "bundle adjustment: nothing to adjust with {} features and {} free parameters",
                num_offered, RowsOf(terms.free).count);
  }

  RigOutcome outcome;
  const Result<int> iterations = options.paper ? SolveBundle(terms, kPaperLimits, execution, unknowns)
                                               : SolveRobustly(options, execution, terms, unknowns, outcome);
  if (!iterations) return Fail(iterations.error());
  const bool gauge_is_free = !terms.rig && !terms.free.AnyPoseFixed();
  if (gauge_is_free && !terms.anchors.empty()) {
    MoveToFrame(AlignmentToSeed(unknowns.calibration, terms.anchors), unknowns.calibration, unknowns.measurements);
  }

  Adjustment out{.calibration = std::move(unknowns.calibration)};
  const MeasurementSet& measurements = unknowns.measurements;
  const FitResiduals residuals = ResidualsOf(out.calibration, measurements);
  const double cauchy_scale = options.paper ? 0 : options.cauchy_scale_px / options.noise.observation_sigma_px;
  const NoiseEstimate noise =
      EstimateNoise(residuals.sigmas, cauchy_scale,
                    NumCameraParameters(terms) + 3 * static_cast<int>(measurements.x_in_world.size()));
  out.tracks = TracksAfter(tracks, measurements);
  TriangulateHeldOut(out.calibration, out.tracks);
  out.report.num_iterations = *iterations;
  out.report.num_dropped_observations = num_offered - static_cast<int>(measurements.items.size());
  out.report.num_dropped_tracks = num_offered_tracks - static_cast<int>(measurements.x_in_world.size());
  out.report.observation_sigma_px = noise.sigma * options.noise.observation_sigma_px;
  ReportFit(residuals, measurements, expected_error_px, options, out.report);
  if (terms.rig) {
    outcome.state = std::move(*unknowns.rig);
    outcome.stop_error_sigma.assign(terms.rig->stops.size(), StopError::Zero());
    out.rig = std::move(outcome);
  }
  if (options.estimate_covariance && !options.paper && (!gauge_is_free || !terms.anchors.empty())) {
    WritePosterior(measurements, noise, terms, out);
  }
  execution.Report(1);
  return out;
}

}  // namespace rigcal
