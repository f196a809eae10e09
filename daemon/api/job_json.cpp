#include "daemon/api/job_json.h"

#include "config/run_report.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Json TextOrNull(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

template <typename Value>
Json ValueOrNull(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json ProgressJson(const JobProgress& progress) {
  const RunProgress& run = progress.run;
  return {{"stage", run.stage},
          {"round", run.round >= 0 ? Json(run.round + 1) : Json(nullptr)},
          {"rounds", run.round >= 0 ? Json(run.num_rounds) : Json(nullptr)},
          {"stage_share", run.stage_share},
          {"share", ValueOrNull(run.run_share)},
          {"left_s", ValueOrNull(progress.left_s)},
          {"text", ProgressText(progress)}};
}

Json OutcomeJson(const JobOutcome& outcome) {
  return {{"verdict", outcome.verdict ? Json(NameOf(*outcome.verdict)) : Json(nullptr)},
          {"revision", ValueOrNull(outcome.revision)},
          {"message", outcome.message},
          {"exit_status", outcome.exit_status}};
}

}  // namespace

Json JobJson(const JobStatus& status) {
  const Job& job = status.job;
  return {{"id", job.id},
          {"kind", job.kind},
          {"state", NameOf(job.state)},
          {"request", Json::parse(job.request, nullptr, false)},
          {"by", job.by},
          {"queued_at", TextOrNull(job.queued_at)},
          {"begun_at", TextOrNull(job.begun_at)},
          {"ended_at", TextOrNull(job.ended_at)},
          {"recording", TextOrNull(job.recording)},
          {"cancel_requested", status.cancel_requested},
          {"sequence", status.sequence},
          {"progress", status.progress ? ProgressJson(*status.progress) : Json(nullptr)},
          {"outcome", HasEnded(job.state) ? OutcomeJson(job.outcome) : Json(nullptr)}};
}

}  // namespace rigcal
