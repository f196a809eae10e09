#include "daemon/jobs/job_kinds.h"

namespace rigcal {

Result<JobOutcome> ReplayJob(JobWork& work) {
  const auto recording = NamedRecording(work);
  if (!recording) return Fail(recording.error());
  if (auto kept = work.handle.SetRecording((*recording)->string()); !kept) return Fail(kept.error());
  const auto start = TakeCalibrationInForce(work);
  if (!start) return Fail(start.error());
  const auto result = RefineRecording(work, *start, **recording);
  if (!result) return Fail(result.error());
  return StoreAndPublish(work, *result, **recording, start->revision);
}

}  // namespace rigcal
