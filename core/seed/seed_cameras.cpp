#include "core/seed/seed_cameras.h"

#include <algorithm>
#include <cmath>

#include "core/rig/camera_information.h"
#include "core/seed/chart_problem.h"
#include "core/seed/check_board.h"
#include "core/seed/corner_noise.h"
#include "core/seed/rig_contradictions.h"
#include "core/seed/seed_advice.h"
#include "core/seed/seed_posterior.h"
#include "core/seed/start_cameras.h"
#include "core/seed/start_rig.h"

namespace rigcal {
namespace {

/// Robust loss while it is not known what fits: 95 % efficient would be 2.4; smaller lets go of gross errors sooner.
constexpr double kStartCauchySigmas = 2;
/// Stop errors beyond this many of their sigmas pull ever less while slips are looked for.
constexpr double kStopCauchySigmas = 3;
constexpr int kRobustRounds = 2;         ///< solve, find the noise, solve again
constexpr int kContradictionRounds = 3;  ///< what is taken out uncovers what it hid
constexpr int kNoiseRounds = 3;          ///< of the final fit: the scale moves by less than 1e-3 in the last

/// Bad input that would otherwise be a bug further on.
Result<void> CheckScene(const SeedScene& scene) {
  const auto num_cameras = static_cast<int>(scene.cameras.size());
  const auto num_stops = static_cast<int>(scene.stops.size());
  if (const Result<void> board = CheckBoard(scene.board); !board) return Fail(board.error());
  for (const SeedView& view : scene.views) {
    if (view.camera < 0 || view.camera >= num_cameras) {
      return Fail(ErrorCode::kBadInput, "view {}: there is no camera {}", view.name, view.camera);
    }
    if (view.stop && (*view.stop < 0 || *view.stop >= num_stops)) {
      return Fail(ErrorCode::kBadInput, "view {}: there is no stop {}", view.name, *view.stop);
    }
  }
  if (!scene.rig) return {};
  const Positioner& positioner = scene.rig->positioner;
  const bool arm = positioner.kind == PositionerKind::kArm;
  const std::size_t num_axes = arm ? 0 : positioner.kind == PositionerKind::kTurntable ? 1 : positioner.num_axes;
  for (const StopPosition& stop : scene.stops) {
    if (arm != stop.base_from_flange.has_value() || (!arm && stop.axes.size() != num_axes)) {
      return Fail(ErrorCode::kBadInput, "stop {}: the rig needs {}, the stop has {} axis values and {} flange pose",
                  stop.id, arm ? "a flange pose" : fmt::format("{} axis values", num_axes), stop.axes.size(),
                  stop.base_from_flange ? "a" : "no");
    }
  }
  return {};
}

/// The corners of the views that see enough of the board.
Result<ChartTerms> TermsOf(const SeedScene& scene, const SeedOptions& options) {
  ChartTerms terms;
  terms.board = scene.board;
  terms.bow_sigma_m = options.bow_sigma_m;
  terms.stretch_sigma = options.stretch_sigma;
  terms.noise_scale.assign(scene.cameras.size(), 1.0);
  terms.uses_k3.assign(scene.cameras.size(), false);
  for (const SeedView& view : scene.views) terms.views.push_back({view.camera, std::nullopt, {}});
  for (const ChartSighting& sighting : scene.sightings) {
    if (sighting.view < 0 || sighting.view >= static_cast<int>(terms.views.size())) {
      return Fail(ErrorCode::kBadInput, "a sighting of the chart names view {}; there are {}", sighting.view,
                  terms.views.size());
    }
    for (const ChartCorner& corner : sighting.corners) {
      if (!scene.board.HasTag(corner.tag_id)) {
        return Fail(ErrorCode::kBadInput, "view {}: tag {} is not on the chart", scene.views[sighting.view].name,
                    corner.tag_id);
      }
    }
    if (static_cast<int>(sighting.corners.size()) < options.min_corners_per_view) continue;
    terms.views[sighting.view].corners = sighting.corners;
  }
  return terms;
}

/// Connects the views at stops to the rig model, if any of them sees the chart.
Result<void> JoinRig(const SeedScene& scene, ChartTerms& terms, ChartState& state) {
  state.rig.cam_from_mount.assign(scene.cameras.size(), std::nullopt);
  bool any = false;
  for (std::size_t v = 0; scene.rig && v < scene.views.size(); ++v) {
    any = any || (scene.views[v].stop && !terms.views[v].corners.empty());
  }
  if (!any) return {};
  for (std::size_t v = 0; v < scene.views.size(); ++v) terms.views[v].stop = scene.views[v].stop;
  terms.stops = scene.stops;
  terms.stop_error_sigma.assign(scene.stops.size(), scene.rig->error_sigma);
  return StartRig(terms, *scene.rig, state);
}

/// Solves with losses that let go of what does not fit, finding each camera's noise on the way.
Result<int> FitRobustly(const Execution& execution, ChartTerms& terms, ChartState& state) {
  int iterations = 0;
  for (int round = 0; round < kRobustRounds; ++round) {
    terms.noise_scale = RobustScales(terms, ResidualsOf(terms, state));
    const ChartLosses losses{.corner_cauchy = kStartCauchySigmas, .stop_error_cauchy = kStopCauchySigmas};
    const Result<int> solved = ChartProblem(terms, losses, state).Solve(execution, state);
    if (!solved) return Fail(solved.error());
    iterations += *solved;
  }
  terms.noise_scale = RobustScales(terms, ResidualsOf(terms, state));
  return iterations;
}

/// Solves with the final losses until the cameras' noise is found.
Result<int> FitFinally(const SeedOptions& options, const Execution& execution, ChartTerms& terms, ChartState& state) {
  int iterations = 0;
  for (int round = 0; round < kNoiseRounds; ++round) {
    if (execution.Stopped()) return Cancelled("seeding");
    ChartProblem problem(terms, {.corner_huber = options.huber_sigmas}, state);
    const Result<int> solved = problem.Solve(execution, state);
    if (!solved) return Fail(solved.error());
    iterations += *solved;
    terms.noise_scale = FittedScales(terms, problem.Linearise());
  }
  return iterations;
}

/// Frees k3 where the chi-square that it would gain, to first order, is above its cost by Schwarz's criterion: the
/// logarithm of the number of coordinates. Tells whether any camera did.
bool ChooseK3(const SeedOptions& options, ChartTerms& terms, const ChartState& state, SeedReport& report) {
  ChartTerms all = terms;
  all.uses_k3.assign(terms.uses_k3.size(), true);
  ChartProblem problem(all, {.corner_huber = options.huber_sigmas}, state);
  const ChartLinearisation fit = problem.Linearise();
  const Eigen::VectorXd step = fit.covariance * fit.gradient;
  bool any = false;
  for (std::size_t c = 0; c < terms.uses_k3.size(); ++c) {
    SeedCameraReport& camera = report.cameras[c];
    const int k3 = problem.Columns().intrinsics[c][kK3];
    camera.k3_gain = step[k3] * step[k3] / fit.covariance(k3, k3);
    camera.k3_cost = std::log(2.0 * std::max(1, camera.num_corners));
    camera.uses_k3 = camera.k3_gain > camera.k3_cost;
    terms.uses_k3[c] = camera.uses_k3;
    any = any || camera.uses_k3;
  }
  return any;
}

void ReportResiduals(const ChartTerms& terms, const ChartState& state, SeedReport& report) {
  const CornerResiduals residuals = ResidualsOf(terms, state);
  double sum2 = 0;
  int count = 0;
  std::vector<double> camera_sum2(report.cameras.size(), 0.0);
  for (SeedCameraReport& camera : report.cameras) camera.num_corners = camera.num_views = 0;
  report.view_rms_px.assign(terms.views.size(), 0.0);
  for (std::size_t v = 0; v < terms.views.size(); ++v) {
    if (residuals.px[v].empty()) continue;
    SeedCameraReport& camera = report.cameras[terms.views[v].camera];
    double view_sum2 = 0;
    for (const double px : residuals.px[v]) view_sum2 += px * px;
    const auto num = static_cast<int>(residuals.px[v].size());
    report.view_rms_px[v] = std::sqrt(view_sum2 / num);
    camera_sum2[terms.views[v].camera] += view_sum2;
    camera.num_corners += num, camera.num_views += 1;
    sum2 += view_sum2, count += num;
  }
  for (std::size_t c = 0; c < report.cameras.size(); ++c) {
    report.cameras[c].rms_px = std::sqrt(camera_sum2[c] / std::max(1, report.cameras[c].num_corners));
    report.cameras[c].noise_scale = terms.noise_scale[c];
  }
  report.rms_px = std::sqrt(sum2 / std::max(1, count));
}

/// Index of the camera's view with the largest residuals.
int WorstView(const SeedScene& scene, int camera, const SeedReport& report) {
  int worst = -1;
  for (int v = 0; v < static_cast<int>(scene.views.size()); ++v) {
    if (scene.views[v].camera != camera) continue;
    if (worst < 0 || report.view_rms_px[v] > report.view_rms_px[worst]) worst = v;
  }
  return worst;
}

/// Why a calibration must not be used; the first camera that fails and its worst view are named.
Result<void> CheckFit(const SeedScene& scene, const SeedOptions& options, const SeedReport& report) {
  /// More corners than this grossly wrong: what is left is a choice, not a measurement.
  constexpr double kMaxOutlierShare = 0.1;
  for (std::size_t c = 0; c < report.cameras.size(); ++c) {
    const SeedCameraReport& camera = report.cameras[c];
    if (camera.rms_px > options.max_rms_px) {
      const int worst = WorstView(scene, static_cast<int>(c), report);
      return Fail(
          ErrorCode::kBadInput,
          "camera {}: the chart's corners are {:.2f} px (RMS) from where the calibration puts them, {:.2f} px are "
          "allowed; worst view {} with {:.2f} px: blurred pictures, a bent board, a wrong chart file or a lens "
          "that Brown's model does not fit",
          scene.cameras[c].id, camera.rms_px, options.max_rms_px, scene.views[worst].name, report.view_rms_px[worst]);
    }
    if (camera.num_outliers > kMaxOutlierShare * (camera.num_outliers + camera.num_corners)) {
      return Fail(ErrorCode::kBadInput,
                  "camera {}: {} of {} corners of the chart are grossly off, {:.0f} % are allowed: the pictures do not "
                  "show the board of the chart file",
                  scene.cameras[c].id, camera.num_outliers, camera.num_outliers + camera.num_corners,
                  100 * kMaxOutlierShare);
    }
  }
  return {};
}

/// Everything from the starting values to the final fit. On return `terms` holds what was used.
Result<void> Fit(const SeedScene& scene, const SeedOptions& options, const Execution& execution, ChartTerms& terms,
                 ChartState& state, SeedReport& report) {
  for (int round = 0; round < kContradictionRounds; ++round) {
    const Result<int> robust = FitRobustly(execution, terms, state);
    if (!robust) return Fail(robust.error());
    report.num_iterations += *robust;
    if (terms.stops.empty()) break;
    const auto found = TakeOutContradictions(scene, options, state, terms);
    if (found.empty()) break;
    report.contradictions.insert(report.contradictions.end(), found.begin(), found.end());
  }
  const auto dropped = DropGrossCorners(ResidualsOf(terms, state), static_cast<int>(scene.cameras.size()), terms);
  for (std::size_t c = 0; c < dropped.size(); ++c) report.cameras[c].num_outliers = dropped[c];
  Result<int> fitted = FitFinally(options, execution, terms, state);
  if (!fitted) return Fail(fitted.error());
  report.num_iterations += *fitted;
  ReportResiduals(terms, state, report);
  if (ChooseK3(options, terms, state, report)) {
    fitted = FitFinally(options, execution, terms, state);
    if (!fitted) return Fail(fitted.error());
    report.num_iterations += *fitted;
    ReportResiduals(terms, state, report);
  }
  if (!terms.stops.empty()) {
    const auto understated = UnderstatedErrors(scene, terms, state);
    report.contradictions.insert(report.contradictions.end(), understated.begin(), understated.end());
    const Eigen::Vector3d print_in_world = WorldFromBoard(state.place, 0).rotation * Eigen::Vector3d::UnitZ();
    if (print_in_world.z() < 0) {
      report.contradictions.emplace_back(
          "the board's print faces down on the table: the positioner turns against its stated angles, or the print is "
          "mirrored");
    }
  }
  return {};
}

}  // namespace

Result<SeedResult> SeedCameras(const SeedScene& scene, const SeedOptions& options, const Execution& execution) {
  if (const Result<void> checked = CheckScene(scene); !checked) return Fail(checked.error());
  Result<ChartTerms> terms = TermsOf(scene, options);
  if (!terms) return Fail(terms.error());
  Result<ChartState> state = StartCameras(scene, options, execution, terms->views);
  if (!state) return Fail(state.error());
  if (const Result<void> joined = JoinRig(scene, *terms, *state); !joined) return Fail(joined.error());

  SeedResult result;
  result.report.cameras.resize(scene.cameras.size());
  if (const auto fitted = Fit(scene, options, execution, *terms, *state, result.report); !fitted) {
    return Fail(fitted.error());
  }
  if (const auto usable = CheckFit(scene, options, result.report); !usable) return Fail(usable.error());
  ChartProblem problem(*terms, {.corner_huber = options.huber_sigmas}, *state);
  const ChartLinearisation fit = problem.Linearise();
  WriteSolution(scene, *terms, *state, problem.Columns(), fit.covariance, result);
  ReportCoverage(scene, *terms, *state, result.report);
  result.report.advice = Advise(scene, *terms, *state, problem.Columns(), fit.covariance, result.report);
  return result;
}

}  // namespace rigcal
