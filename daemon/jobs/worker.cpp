#include "daemon/jobs/worker.h"

#include <exception>
#include <utility>

namespace rigcal {
namespace {

/// The only place where what a bug throws is caught.
Result<JobOutcome> Run(const Worker::RunJob& run, JobHandle& handle) {
  try {
    return run(handle);
  } catch (const std::exception& bug) {
    return Fail(ErrorCode::kIo, "internal error: {}", bug.what());
  }
}

}  // namespace

void JobHandle::Report(const RunProgress& progress) {
  queue_.Report(begun_.job.id, {.run = progress});
}

std::function<void(const RunProgress&)> JobHandle::Listener() {
  return [this, begin_s = clock_.NowS()](const RunProgress& progress) {
    queue_.Report(begun_.job.id, {progress, TimeLeftS(progress, clock_.NowS() - begin_s)});
  };
}

Worker::Worker(JobQueue& queue, Clock& clock, RunJob run, std::function<void(const Job&)> ended)
    : queue_(queue), clock_(clock), run_(std::move(run)), ended_(std::move(ended)), thread_([this] { Loop(); }) {}

Worker::~Worker() {
  queue_.Close();
}

void Worker::Loop() {
  while (const std::optional<BegunJob> begun = queue_.TakeNext()) {
    JobHandle handle(queue_, clock_, *begun);
    queue_.End(begun->job.id, Run(run_, handle));
    const Result<JobStatus> status = queue_.Find(begun->job.id);
    if (status && ended_) ended_(status->job);
  }
}

}  // namespace rigcal
