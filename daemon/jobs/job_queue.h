#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "config/job_journal.h"
#include "core/base/clock.h"
#include "core/base/result.h"
#include "daemon/jobs/job_progress.h"

namespace rigcal {

/// A job as it stands now.
struct JobStatus {
  Job job;
  std::uint64_t sequence = 0;  ///< of its last change; rises over all jobs
  bool cancel_requested = false;
  std::optional<JobProgress> progress;  ///< while it runs
};

/// A job that was taken from the queue, and the token by which it is stopped.
struct BegunJob {
  Job job;
  std::stop_token stop;
};

struct JobQueueOptions {
  std::size_t max_waiting = 16;  ///< jobs that wait; a night's worth, and a person would not look through more
  std::size_t max_ended = 64;    ///< that are remembered beside the journal, for listeners who come a little late
  double report_every_s = 0.2;   ///< a person reads no faster; with 64 listeners it is 320 messages a second
  std::function<void(const Error&)> journal_failed;  ///< told when a change could not be kept; may be empty
};

/// The jobs of a service, between those who ask and the worker. Every change is in the journal before it counts. Safe
/// to use from any thread.
class JobQueue {
 public:
  /// `journal` and `clock` outlive it and belong to it alone; `now_text` tells the time in UTC.
  JobQueue(JobJournal& journal, Clock& clock, std::function<std::string()> now_text, JobQueueOptions options = {});

  /// Errors: kConflict: the queue is full or closed; those of JobJournal.
  Result<Job> Submit(const std::string& kind, const std::string& request, const std::string& by);
  /// A job that waits is cancelled at once, one that runs is asked to stop. Errors: kNotFound; kConflict: it has ended.
  Result<JobStatus> Cancel(int id);
  /// Errors: kNotFound; those of JobJournal.
  Result<JobStatus> Find(int id);
  /// Newest first. Errors: those of JobJournal.
  Result<std::vector<JobStatus>> Newest(int count);
  /// How many wait, and the one that runs.
  std::size_t NumWaiting();
  std::optional<JobStatus> Running();

  /// Waits until a job has changed after `sequence`, at most `timeout_s` of the machine's time; then it is given as it
  /// stands, changed or not. Errors: as Find; kCancelled: the queue was closed or the token is set.
  Result<JobStatus> WaitForChange(int id, std::uint64_t sequence, double timeout_s, const std::stop_token& stop);

  /// No job is taken any more, the running one is asked to stop and those that wait become interrupted. Listeners go.
  void Close();
  /// Since when the running job has been asked to stop without stopping; for the watchdog.
  std::optional<double> StoppingForS();

  // For the worker alone.

  /// Waits for the next job and marks it as running. Nothing: the queue was closed.
  std::optional<BegunJob> TakeNext();
  void Report(int id, const JobProgress& progress);
  /// Errors: those of JobJournal: a recording that no journal names must not be begun.
  Result<void> SetRecording(int id, const std::string& folder);
  void End(int id, const Result<JobOutcome>& result);

 private:
  struct Entry {
    JobStatus status;
    std::stop_source stop;
    double reported_s = 0;
    std::optional<double> stopping_since_s;
  };
  using Lock = std::unique_lock<std::mutex>;

  void Changed(Entry& entry);
  void Keep(const Job& job);
  void Finish(Entry& entry, JobState state, JobOutcome outcome);
  Result<JobStatus> FindLocked(int id);
  [[nodiscard]] bool IsStopping(const Entry& entry) const { return closed_ || entry.status.cancel_requested; }

  JobJournal& journal_;
  Clock& clock_;
  std::function<std::string()> now_text_;
  JobQueueOptions options_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<int, Entry> entries_;  ///< that wait, run, or ended a short while ago
  std::deque<int> waiting_;
  std::optional<int> running_;
  std::uint64_t sequence_ = 0;
  bool closed_ = false;
};

}  // namespace rigcal
