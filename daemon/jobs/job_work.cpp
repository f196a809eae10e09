#include "daemon/jobs/job_work.h"

#include <algorithm>
#include <utility>

#include "config/atomic_file.h"
#include "config/recording_file.h"
#include "config/result_folder.h"
#include "config/run_report.h"
#include "core/base/joined.h"
#include "daemon/capture_request.h"
#include "daemon/run_request.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// "20260131T235959Z-12-object": sorts by time, and no two are the same.
std::string RecordingName(const JobWork& work, Subject subject) {
  std::string time = work.now_text();
  std::erase_if(time, [](char c) { return c == '-' || c == ':'; });
  return fmt::format("{}-{}-{}", time, work.handle.Content().id, NameOf(subject));
}

/// A request may name any recording to read, and only one of the service's own to write to.
bool IsOwn(const JobWork& work, const fs::path& recording) {
  std::error_code error;
  return fs::weakly_canonical(recording, error).parent_path() == fs::weakly_canonical(work.station.Recordings(), error);
}

/// Where an acquisition stands, as a run says it.
RunProgress ProgressOf(const AcquisitionProgress& acquisition) {
  RunProgress progress{.stage = fmt::format("stop {}: {}", acquisition.stop + 1, NameOf(acquisition.phase))};
  if (acquisition.num_stops) {
    progress.stage =
        fmt::format("stop {} of {}: {}", acquisition.stop + 1, *acquisition.num_stops, NameOf(acquisition.phase));
    progress.stage_share = static_cast<double>(acquisition.stop) / std::max(1, *acquisition.num_stops);
  }
  return progress;
}

std::string OutcomeText(const RevisionHead& head, int revision) {
  if (head.reasons.empty()) return fmt::format("revision {}: accepted", revision);
  return fmt::format("revision {}: {}: {}", revision, NameOf(head.verdict), Joined(head.reasons, "; "));
}

}  // namespace

Result<StartingPoint> TakeCalibrationInForce(JobWork& work) {
  const std::string& rig = work.station.name;
  const auto in_force = work.store.InForce(rig);
  if (!in_force) return Fail(in_force.error());
  if (!*in_force) {
    return Fail(ErrorCode::kNotFound, "rig '{}': no calibration is in force; `rigcal seed-chart` makes the first", rig);
  }
  const auto revision = work.store.Load(rig, (*in_force)->revision);
  if (!revision) return Fail(revision.error());
  const fs::path folder = work.station.JobFolder(work.handle.Content().id);
  if (auto ready = PrepareOutputFolder(folder); !ready) return Fail(ready.error());
  StartingPoint start{.calibration = folder / "calibration.json", .revision = revision->head.number};
  if (auto kept = WriteFileAtomically(start.calibration, revision->calibration_text); !kept) return Fail(kept.error());
  return start;
}

Result<std::optional<fs::path>> NamedRecording(const JobWork& work) {
  const auto named = work.request.find("recording");
  if (named == work.request.end()) return std::optional<fs::path>();
  // A name below the state folder; an absolute path replaces it.
  fs::path folder = work.station.Recordings() / named->get<std::string>();
  std::error_code error;
  if (fs::exists(folder / kRecordingFile, error)) return std::optional(std::move(folder));
  return Fail(ErrorCode::kNotFound, "{}: there is no recording", folder.string());
}

Result<fs::path> AcquireRecording(JobWork& work, Subject subject) {
  const auto named = NamedRecording(work);
  if (!named) return Fail(named.error());
  CaptureWish wish{.subject = subject};
  wish.out = named->value_or(work.station.Recordings() / RecordingName(work, subject));
  wish.stops = work.request.value("stops", std::vector<double>());
  if (*named) {
    const Result<Recording> recording = LoadRecording(wish.out);
    if (!recording) return Fail(recording.error());
    if (auto kept = work.handle.SetRecording(wish.out.string()); !kept) return Fail(kept.error());
    if (recording->closed) return wish.out;
    if (!IsOwn(work, wish.out)) {
      return Fail(ErrorCode::kBadInput, "{}: is not closed, and no recording of the service's to go on with",
                  wish.out.string());
    }
    wish.resume = true;
  }
  Result<PreparedCapture> capture = PrepareCapture(wish, work.station.rig, work.station.rig_file.string());
  if (!capture) return Fail(capture.error());
  capture->context.tell = work.tell;
  if (auto kept = work.handle.SetRecording(wish.out.string()); !kept) return Fail(kept.error());
  const auto listener = [&](const AcquisitionProgress& progress) { work.handle.Report(ProgressOf(progress)); };
  const Result<CaptureOutcome> outcome = CaptureWithDevices(*capture, work.clock, listener, work.handle.Stop());
  if (!outcome) return Fail(outcome.error());
  return wish.out;
}

Result<fs::path> RefineRecording(JobWork& work, const StartingPoint& start, const fs::path& recording) {
  RunRequest request;
  request.pictures.recording = recording;
  request.cameras = start.calibration;
  request.out = start.calibration.parent_path() / "result";
  request.num_rounds = work.request.value("rounds", request.num_rounds);
  request.random_seed = work.request.value("random_seed", request.random_seed);
  request.masks.source = work.request.value("masks", request.masks.source);
  if (work.request.contains("expected_error_px")) {
    request.expected_error_px = work.request["expected_error_px"].get<double>();
  }
  RunContext context(
      work.handle.Stop(), work.station.num_threads, [&work] { return work.clock.NowS(); }, work.handle.Listener());
  const Result<RefinedRig> refined = RefineFiles(request, context);
  if (!refined) return Fail(refined.error());
  return request.out;
}

Result<JobOutcome> StoreAndPublish(JobWork& work, const fs::path& result, const fs::path& recording,
                                   const std::optional<int>& expected) {
  const std::string& rig = work.station.name;
  const auto revision = RevisionFromResult(result, recording, rig, work.now_text(), work.store);
  if (!revision) return Fail(revision.error());
  const Result<int> number = work.store.Append(*revision);
  if (!number) return Fail(number.error());
  const RevisionHead& head = revision->head;
  JobOutcome outcome{.verdict = head.verdict,
                     .revision = *number,
                     .message = OutcomeText(head, *number),
                     .exit_status = head.verdict == Verdict::kAccepted ? kJobAccepted : kJobNotAccepted};
  if (head.verdict != Verdict::kAccepted) return outcome;
  const Job& job = work.handle.Content();
  const PublishRequest request{.rig = rig,
                               .revision = *number,
                               .expected = expected,
                               .time = work.now_text(),
                               .by = fmt::format("rigcald job {} ({}) for {}", job.id, job.kind, job.by),
                               .reason = {}};
  const auto published = PublishRevision(work.store, request, work.station.publish, work.clock, work.handle.Stop());
  if (!published) {
    outcome.message += ", but not published: " + published.error().message;
    outcome.exit_status = kJobFailed;
    return outcome;
  }
  for (const std::string& note : published->notes) work.tell(note);
  return outcome;
}

}  // namespace rigcal
