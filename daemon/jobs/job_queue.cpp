#include "daemon/jobs/job_queue.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

constexpr const char *kServiceEnded = "the service ended before the job began",
                     *kServiceStopped = "the service was stopped while the job ran",
                     *kCancelledInQueue = "cancelled before it began", *kCancelledByRequest = "cancelled on request";

bool SameStage(const std::optional<JobProgress>& before, const JobProgress& now) {
  return before && before->run.stage == now.run.stage && before->run.round == now.run.round;
}

}  // namespace

JobQueue::JobQueue(JobJournal& journal, Clock& clock, std::function<std::string()> now_text, JobQueueOptions options)
    : journal_(journal), clock_(clock), now_text_(std::move(now_text)), options_(std::move(options)) {}

void JobQueue::Changed(Entry& entry) {
  entry.status.sequence = ++sequence_;
  changed_.notify_all();
}

void JobQueue::Keep(const Job& job) {
  const Result<void> kept = journal_.Update(job);
  if (!kept && options_.journal_failed) options_.journal_failed(kept.error());
}

Result<Job> JobQueue::Submit(const std::string& kind, const std::string& request, const std::string& by) {
  const Lock lock(mutex_);
  if (closed_) return Fail(ErrorCode::kConflict, "the service is being stopped and takes no more jobs");
  if (waiting_.size() >= options_.max_waiting) {
    return Fail(ErrorCode::kConflict, "{} jobs are waiting, no more than {} may", waiting_.size(),
                options_.max_waiting);
  }
  Job job{.kind = kind, .request = request, .by = by, .queued_at = now_text_()};
  const Result<int> id = journal_.Append(job);
  if (!id) return Fail(id.error());
  job.id = *id;
  Entry& entry = entries_[job.id];
  entry.status.job = job;
  waiting_.push_back(job.id);
  Changed(entry);
  return job;
}

Result<JobStatus> JobQueue::Cancel(int id) {
  const Lock lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end() || HasEnded(found->second.status.job.state)) {
    const Result<JobStatus> ended = FindLocked(id);
    if (!ended) return ended;
    return Fail(ErrorCode::kConflict, "job {} has ended already: {}", id, NameOf(ended->job.state));
  }
  Entry& entry = found->second;
  if (entry.status.job.state == JobState::kQueued) {
    std::erase(waiting_, id);
    Finish(entry, JobState::kCancelled, {.message = kCancelledInQueue});
    return entry.status;
  }
  entry.status.cancel_requested = true;
  if (!entry.stopping_since_s) entry.stopping_since_s = clock_.NowS();
  entry.stop.request_stop();
  Changed(entry);
  return entry.status;
}

void JobQueue::Finish(Entry& entry, JobState state, JobOutcome outcome) {
  Job& job = entry.status.job;
  job.state = state;
  job.outcome = std::move(outcome);
  job.ended_at = now_text_();
  entry.status.progress.reset();
  entry.stopping_since_s.reset();
  Keep(job);
  Changed(entry);
}

Result<JobStatus> JobQueue::FindLocked(int id) {
  if (const auto found = entries_.find(id); found != entries_.end()) return found->second.status;
  Result<Job> job = journal_.Load(id);
  if (!job) return Fail(job.error());
  return JobStatus{.job = std::move(*job)};
}

Result<JobStatus> JobQueue::Find(int id) {
  const Lock lock(mutex_);
  return FindLocked(id);
}

Result<std::vector<JobStatus>> JobQueue::Newest(int count) {
  const Lock lock(mutex_);
  Result<std::vector<Job>> jobs = journal_.Newest(count);
  if (!jobs) return Fail(jobs.error());
  std::vector<JobStatus> statuses;
  for (Job& job : *jobs) {
    const auto found = entries_.find(job.id);
    statuses.push_back(found == entries_.end() ? JobStatus{.job = std::move(job)} : found->second.status);
  }
  return statuses;
}

std::size_t JobQueue::NumWaiting() {
  const Lock lock(mutex_);
  return waiting_.size();
}

std::optional<JobStatus> JobQueue::Running() {
  const Lock lock(mutex_);
  if (!running_) return std::nullopt;
  return entries_.at(*running_).status;
}

Result<JobStatus> JobQueue::WaitForChange(int id, std::uint64_t sequence, double timeout_s,
                                          const std::stop_token& stop) {
  Lock lock(mutex_);
  const auto has_changed = [&] {
    const auto found = entries_.find(id);
    return closed_ || found == entries_.end() || found->second.status.sequence > sequence;
  };
  changed_.wait_for(lock, stop, std::chrono::duration<double>(timeout_s), has_changed);
  const Result<JobStatus> status = FindLocked(id);
  if (!status) return status;
  if (!HasEnded(status->job.state) && (closed_ || stop.stop_requested())) {
    return Fail(ErrorCode::kCancelled, "waiting for job {} was stopped", id);
  }
  return status;
}

void JobQueue::Close() {
  const Lock lock(mutex_);
  closed_ = true;
  for (const int id : std::exchange(waiting_, {})) {
    Finish(entries_.at(id), JobState::kInterrupted, {.message = kServiceEnded});
  }
  if (running_) {
    Entry& entry = entries_.at(*running_);
    if (!entry.stopping_since_s) entry.stopping_since_s = clock_.NowS();
    entry.stop.request_stop();
  }
  changed_.notify_all();
}

std::optional<double> JobQueue::StoppingForS() {
  const Lock lock(mutex_);
  if (!running_) return std::nullopt;
  const auto& since_s = entries_.at(*running_).stopping_since_s;
  return since_s ? std::optional(clock_.NowS() - *since_s) : std::nullopt;
}

std::optional<BegunJob> JobQueue::TakeNext() {
  Lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return closed_ || !waiting_.empty(); });
    if (closed_) return std::nullopt;
    Entry& entry = entries_.at(waiting_.front());
    waiting_.pop_front();
    Job& job = entry.status.job;
    job.state = JobState::kRunning;
    job.begun_at = now_text_();
    if (const Result<void> kept = journal_.Update(job); !kept) {
      Finish(entry, JobState::kFailed, {.message = "not begun: " + kept.error().message});
      continue;
    }
    running_ = job.id;
    Changed(entry);
    return BegunJob{job, entry.stop.get_token()};
  }
}

void JobQueue::Report(int id, const JobProgress& progress) {
  const Lock lock(mutex_);
  Entry& entry = entries_.at(id);
  const double now_s = clock_.NowS();
  const bool is_soon = now_s - entry.reported_s < options_.report_every_s;
  if (is_soon && SameStage(entry.status.progress, progress)) return;
  entry.reported_s = now_s;
  entry.status.progress = progress;
  Changed(entry);
}

Result<void> JobQueue::SetRecording(int id, const std::string& folder) {
  const Lock lock(mutex_);
  Entry& entry = entries_.at(id);
  entry.status.job.recording = folder;
  if (auto kept = journal_.Update(entry.status.job); !kept) return kept;
  Changed(entry);
  return {};
}

void JobQueue::End(int id, const Result<JobOutcome>& result) {
  const Lock lock(mutex_);
  Ensure(running_ == id, "the job that ends is the one that runs");
  Entry& entry = entries_.at(id);
  running_.reset();
  if (result) {
    Finish(entry, JobState::kDone, *result);
  } else if (result.error().code == ErrorCode::kCancelled && IsStopping(entry)) {
    const bool by_request = entry.status.cancel_requested;
    Finish(entry, by_request ? JobState::kCancelled : JobState::kInterrupted,
           {.message = by_request ? kCancelledByRequest : kServiceStopped});
  } else {
    Finish(entry, JobState::kFailed, {.message = result.error().message});
  }
  std::size_t num_ended = entries_.size() - waiting_.size();
  for (auto oldest = entries_.begin(); oldest != entries_.end() && num_ended > options_.max_ended; --num_ended) {
    const bool ended = HasEnded(oldest->second.status.job.state);
    oldest = ended ? entries_.erase(oldest) : std::next(oldest);
  }
}

}  // namespace rigcal
