#include "core/validate/validate.h"

#include <algorithm>

#include "core/base/ensure.h"
#include "core/validate/checks.h"
#include "core/validate/evidence.h"

namespace rigcal {
namespace {

JudgedCase MakeCase(const ValidationInput& input) {
  const RigCalibration& calibration = input.calibration;
  const std::size_t num_views = calibration.views.size();
  Ensure(input.camera_priors.empty() || input.camera_priors.size() == calibration.cameras.size(),
         "validation needs one prior per camera or none");
  Ensure(!input.prior || input.prior->views.size() == num_views, "the prior has the views that are judged");
  Ensure(input.sharpness.empty() || input.sharpness.size() == num_views, "validation needs one sharpness per view");
  for (const Track& track : input.tracks.tracks) {
    for (const Observation& o : track.observations) {
      Ensure(o.view >= 0 && o.view < static_cast<int>(num_views), "a track names a view that is not judged");
    }
  }
  JudgedCase judged{.input = input,
                    .camera_priors = CompletePriors(input),
                    .judging_tracks = TracksToJudgeBy(input.tracks, kMaxJudgingTracks),
                    .num_features = FeatureCounts(input.tracks.tracks, calibration.NumViews()),
                    .excluded = std::vector<bool>(num_views, false),
                    .objections = {},
                    .report = {}};
  for (const View& view : calibration.views) {
    ViewFinding finding;
    finding.name = view.name;
    finding.camera = calibration.cameras[view.camera].id;
    judged.report.views.push_back(finding);
  }
  return judged;
}

ValidationReport Concluded(JudgedCase judged) {
  ValidationReport report = std::move(judged.report);
  report.verdict = Verdict::kAccepted;
  // What speaks against the cameras comes before what could not be told.
  for (const Verdict verdict : {Verdict::kRejected, Verdict::kInconclusive}) {
    for (const Objection& objection : judged.objections) {
      if (objection.verdict != verdict) continue;
      if (report.reasons.empty()) report.verdict = verdict;
      report.reasons.push_back(objection.reason);
    }
  }
  return report;
}

}  // namespace

Result<ValidationReport> Validate(const ValidationInput& input, const Execution& execution) {
  JudgedCase judged = MakeCase(input);
  if (!CheckFinite(&judged)) return Concluded(std::move(judged));
  CheckSupport(&judged);
  for (const auto check : {CheckConnections, CheckSharpness, CheckIntrinsics, CheckViewResiduals, CheckHoldout,
                           CheckEpipolar, CheckDistanceFromPrior, CheckSigma}) {
    if (execution.Stopped()) return Cancelled("validation");
    check(&judged);
  }
  if (const auto checked = CheckBend(&judged, execution); !checked) return Fail(checked.error());
  return Concluded(std::move(judged));
}

}  // namespace rigcal
