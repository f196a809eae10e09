#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "daemon/jobs/job_queue.h"

namespace rigcal {

/// What a job has of the queue while it runs.
class JobHandle {
 public:
  JobHandle(JobQueue& queue, Clock& clock, const BegunJob& begun) : queue_(queue), clock_(clock), begun_(begun) {}

  [[nodiscard]] const Job& Content() const { return begun_.job; }
  [[nodiscard]] const std::stop_token& Stop() const { return begun_.stop; }
  /// Says where the job stands.
  void Report(const RunProgress& progress);
  /// A listener for a run that begins now: the time left is told from here on.
  [[nodiscard]] std::function<void(const RunProgress&)> Listener();
  /// The recording that the job takes or reads is in the journal before it is begun. Errors: those of JobJournal.
  Result<void> SetRecording(const std::string& folder) { return queue_.SetRecording(begun_.job.id, folder); }

 private:
  JobQueue& queue_;
  Clock& clock_;
  BegunJob begun_;
};

/// The thread that runs the jobs, one after the other; nothing else touches devices or runs stages. A bug in a job
/// fails that job alone.
class Worker {
 public:
  /// Must answer a set stop token with kCancelled within two seconds, devices stopped. An outcome: the job came to its
  /// end; an Error: it failed.
  using RunJob = std::function<Result<JobOutcome>(JobHandle& handle)>;

  /// `queue` and `clock` outlive it. `ended` (may be empty) is told of each job when it has ended.
  Worker(JobQueue& queue, Clock& clock, RunJob run, std::function<void(const Job&)> ended);
  /// Closes the queue and waits for the running job to stop.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

 private:
  void Loop();

  JobQueue& queue_;
  Clock& clock_;
  RunJob run_;
  std::function<void(const Job&)> ended_;
  std::jthread thread_;
};

}  // namespace rigcal
