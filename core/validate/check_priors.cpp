#include <algorithm>
#include <cmath>

#include "core/rig/measurements.h"
#include "core/rig/projection_uncertainty.h"
#include "core/validate/checks.h"
#include "core/validate/evidence.h"
#include "core/validate/limits.h"
#include "core/validate/metric_refit.h"
#include "core/validate/view_motion.h"

namespace rigcal {
namespace {

using namespace limits;

/// The view of a camera that only one view uses.
std::optional<std::string> OnlyViewOf(const RigCalibration& calibration, int camera) {
  std::optional<std::string> name;
  for (const View& view : calibration.views) {
    if (view.camera != camera) continue;
    if (name) return std::nullopt;
    name = view.name;
  }
  return name;
}

double StandardDeviation(const std::vector<double>& values) {
  double mean = 0, sum2 = 0;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) mean += v / n;
  for (const double v : values) sum2 += (v - mean) * (v - mean);
  return std::sqrt(sum2 / n);
}

void CheckOneCamera(JudgedCase* judged, int index) {
  const RigCalibration& calibration = judged->input.calibration;
  const Camera& camera = calibration.cameras[index];
  const CameraPrior& prior = judged->camera_priors[index];
  const auto view = OnlyViewOf(calibration, index);
  const double aspect_off = std::abs(camera.fx_px / camera.fy_px - prior.aspect);
  const double aspect_limit = kMaxAspectSigmas * prior.aspect_sigma;
  if (!(aspect_off <= aspect_limit)) {
    judged->Object(Verdict::kRejected, {"aspect", aspect_off, aspect_limit, "fx / fy", view, camera.id});
  }
  const double centre_off = (Eigen::Vector2d(camera.cx_px, camera.cy_px) - prior.principal_point_px).norm();
  const double centre_limit = kMaxPrincipalPointSigmas * prior.principal_point_sigma_px;
  if (!(centre_off <= centre_limit)) {
    judged->Object(Verdict::kRejected, {"principal_point", centre_off, centre_limit, "px", view, camera.id});
  }
  if (!(std::abs(camera.skew_px) <= kMaxSkewPx)) {
    judged->Object(Verdict::kRejected, {"skew", std::abs(camera.skew_px), kMaxSkewPx, "px", view, camera.id});
  }
}

/// Cameras that are one piece of hardware must agree.
void CheckSpread(JudgedCase* judged, const std::vector<int>& members) {
  if (members.size() < 2) return;
  const RigCalibration& calibration = judged->input.calibration;
  std::vector<double> log_focal, cx, cy;
  for (const int c : members) {
    const Camera& camera = calibration.cameras[c];
    log_focal.push_back(0.5 * std::log(camera.fx_px * camera.fy_px));
    cx.push_back(camera.cx_px);
    cy.push_back(camera.cy_px);
  }
  const Camera& first = calibration.cameras[members.front()];
  const std::string& id = first.physical_id.empty() ? first.id : first.physical_id;
  const double focal = StandardDeviation(log_focal);
  if (focal > kMaxFocalSpread) {
    judged->Object(Verdict::kRejected, {"focal_spread", focal, kMaxFocalSpread, "of the focal length", {}, id});
  }
  const double centre = std::hypot(StandardDeviation(cx), StandardDeviation(cy));
  const double limit = kMaxPrincipalPointSpread * first.width_px;
  if (centre > limit) judged->Object(Verdict::kRejected, {"principal_point_spread", centre, limit, "px", {}, id});
}

}  // namespace

std::vector<CameraPrior> CompletePriors(const ValidationInput& input) {
  if (!input.camera_priors.empty()) return input.camera_priors;
  std::vector<CameraPrior> priors;
  for (const Camera& camera : input.calibration.cameras) {
    CameraPrior prior;
    prior.principal_point_px = {0.5 * (camera.width_px - 1), 0.5 * (camera.height_px - 1)};
    prior.principal_point_sigma_px = kBarePrincipalPointShare * camera.width_px;
    priors.push_back(prior);
  }
  return priors;
}

void CheckIntrinsics(JudgedCase* judged) {
  const std::vector<int> physical = PhysicalCameras(judged->input.calibration);
  std::vector<std::vector<int>> members(physical.size());
  for (int c = 0; c < judged->input.calibration.NumCameras(); ++c) {
    CheckOneCamera(judged, c);
    members[physical[c]].push_back(c);
  }
  for (const auto& of_one : members) CheckSpread(judged, of_one);
}

void CheckDistanceFromPrior(JudgedCase* judged) {
  const ValidationInput& input = judged->input;
  if (!input.prior) return;
  const auto motions = ViewMotions(*input.prior, input.calibration, ObjectPoints(*input.prior, judged->judging_tracks));
  if (motions.empty()) return;
  double sum = 0;
  for (const ViewMotion& motion : motions) {
    ViewFinding& finding = judged->report.views[motion.estimate_view];
    finding.moved_px = motion.moved_px;
    if (motion.shift_px.norm() > 0) finding.direction = motion.shift_px.normalized();
    sum += finding.moved_px;
    const double limit = kMaxViewMovedRatio * input.expected_error_px;
    if (input.expected_error_px > 0 && !(finding.moved_px <= limit)) {
      judged->Object(Verdict::kRejected, {"view_distance_from_prior", finding.moved_px, limit, "px", finding.name, {}});
    }
  }
  const double mean = sum / static_cast<double>(motions.size());
  const double limit = kMaxMovedRatio * input.expected_error_px;
  if (input.expected_error_px > 0 && !(mean <= limit)) {
    judged->Object(Verdict::kRejected, {"distance_from_prior", mean, limit, "px", {}, {}});
  }
}

Result<void> CheckBend(JudgedCase* judged, const Execution& execution) {
  // Features of each view in the refit: enough that good cameras move by no more than 0.3 px for the features' noise
  // (tests/validate), and a tenth of a second.
  constexpr int kFeaturesPerView = 60;
  const RigCalibration& calibration = judged->input.calibration;
  TrackSet usable;
  for (Track track : judged->input.tracks.tracks) {
    std::erase_if(track.observations, [&](const Observation& o) { return judged->excluded[o.view]; });
    if (track.observations.size() >= 2) usable.tracks.push_back(std::move(track));
  }
  const auto tracks = SpreadSubset(usable, calibration.NumViews(), kFeaturesPerView);
  const auto points = ObjectPoints(calibration, tracks);
  if (static_cast<int>(points.size()) < kMinHeldOutTracks) return {};
  const auto refit = RefitAsMetric(calibration, tracks, judged->camera_priors, execution);
  if (!refit) return Fail(refit.error());
  const auto report = CompareCameras(calibration, *refit, points, CompareAlignment::kSimilarity);
  if (!report) return {};
  if (!(report->mean_px <= kMaxBendPx)) {
    judged->Object(Verdict::kRejected, {"bend", report->mean_px, kMaxBendPx, "px", {}, {}});
  }
  for (int view = 0; view < report->num_views; ++view) {
    if (!judged->excluded[view] && !(report->view_mean_px[view] <= kMaxViewBendPx)) {
      judged->Object(Verdict::kRejected,
                     {"view_bend", report->view_mean_px[view], kMaxViewBendPx, "px", judged->NameOf(view), {}});
    }
  }
  return {};
}

void CheckSigma(JudgedCase* judged) {
  constexpr int kPointsPerView = 50;
  const RigCalibration& calibration = judged->input.calibration;
  if (!calibration.covariance) return;
  TrackSet located;
  for (Track track : judged->judging_tracks) {
    const auto x_in_world = TriangulateTrack(calibration, track);
    if (!x_in_world) continue;
    track.x_in_world = *x_in_world;
    located.tracks.push_back(std::move(track));
  }
  const auto sigma_px = ProjectionSigmaPx(calibration, ObjectViewPoints(calibration, located, kPointsPerView));
  for (int view = 0; view < calibration.NumViews(); ++view) {
    judged->report.views[view].sigma_px = sigma_px[view];
    if (judged->excluded[view] || sigma_px[view] <= kMaxSigmaPx) continue;
    judged->Object(Verdict::kInconclusive, {"sigma", sigma_px[view], kMaxSigmaPx, "px", judged->NameOf(view), {}});
  }
}

}  // namespace rigcal
