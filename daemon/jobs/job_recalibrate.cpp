#include "daemon/jobs/job_kinds.h"

namespace rigcal {

Result<JobOutcome> RecalibrateJob(JobWork& work) {
  const auto start = TakeCalibrationInForce(work);  // before anything moves
  if (!start) return Fail(start.error());
  const auto recording = AcquireRecording(work, Subject::kObject);
  if (!recording) return Fail(recording.error());
  const auto result = RefineRecording(work, *start, *recording);
  if (!result) return Fail(result.error());
  return StoreAndPublish(work, *result, *recording, start->revision);
}

}  // namespace rigcal
