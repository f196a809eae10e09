#include "config/atomic_file.h"
#include "daemon/jobs/job_kinds.h"
#include "daemon/seed_request.h"

namespace rigcal {
namespace {

/// The recording seeds with the rig file as the service has read it, not as it may be on the disk by now.
Result<std::filesystem::path> SeedRecording(JobWork& work, const std::filesystem::path& recording) {
  const std::filesystem::path folder = work.station.JobFolder(work.handle.Content().id);
  if (auto ready = PrepareOutputFolder(folder); !ready) return Fail(ready.error());
  const SeedRequest request{.recording = recording,
                            .chart = work.station.rig.board,
                            .out = folder / "result",
                            .rig = folder / work.station.rig_file.filename()};
  if (auto kept = WriteFileAtomically(request.rig, work.station.rig_text); !kept) return Fail(kept.error());
  RunContext context(
      work.handle.Stop(), work.station.num_threads, [&work] { return work.clock.NowS(); }, work.handle.Listener());
  const Result<SeededRig> seeded = SeedFiles(request, context);
  if (!seeded) return Fail(seeded.error());
  return request.out;
}

}  // namespace

Result<JobOutcome> SeedChartJob(JobWork& work) {
  const Station& station = work.station;
  if (station.rig.board.empty()) {
    return Fail(ErrorCode::kBadInput, "{}: names no board; [chart] needs one", station.rig_file.string());
  }
  const auto in_force = work.store.InForce(station.name);
  if (!in_force) return Fail(in_force.error());
  const auto expected = *in_force ? std::optional((*in_force)->revision) : std::nullopt;
  const auto recording = AcquireRecording(work, Subject::kChart);
  if (!recording) return Fail(recording.error());
  const auto result = SeedRecording(work, *recording);
  if (!result) return Fail(result.error());
  return StoreAndPublish(work, *result, *recording, expected);
}

}  // namespace rigcal
