#include "daemon/capture_request.h"
#include "daemon/jobs/job_kinds.h"

namespace rigcal {

Result<JobOutcome> CaptureJob(JobWork& work) {
  const Subject subject = SubjectNamed(work.request.value("what", "object")).value_or(Subject::kObject);
  const auto recording = AcquireRecording(work, subject);
  if (!recording) return Fail(recording.error());
  return JobOutcome{.message = fmt::format("recorded in {}", recording->string()), .exit_status = kJobAccepted};
}

}  // namespace rigcal
