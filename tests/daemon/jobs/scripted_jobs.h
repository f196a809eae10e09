#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "config/store/sqlite_journal.h"
#include "daemon/jobs/job_queue.h"
#include "daemon/jobs/worker.h"
#include "tests/config/temporary_folder.h"
#include "tests/support/fake_clock.h"

namespace rigcal {

inline constexpr double kHangS = 60;  ///< far beyond what anything here takes

/// Something that happens once, and those who wait for it.
class Event {
 public:
  void Happen() {
    const std::lock_guard lock(mutex_);
    happened_ = true;
    changed_.notify_all();
  }
  /// False: it did not happen for kHangS.
  bool Await() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::duration<double>(kHangS), [&] { return happened_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool happened_ = false;
};

/// A queue with a journal in a folder of its own, and a clock that stands.
struct QueueBench {
  explicit QueueBench(JobQueueOptions options = {})
      : queue(
            *journal, clock, [] { return Now(); }, std::move(options)) {}
  static std::string Now() { return "2026-02-01T06:00:00Z"; }
  static std::unique_ptr<JobJournal> OpenIn(const std::filesystem::path& folder) {
    auto opened = OpenSqliteJournal(folder / kJournalFile);
    EXPECT_TRUE(opened) << opened.error().message;
    return std::move(*opened);
  }

  int Submit(const std::string& kind = "capture") {
    const Result<Job> job = queue.Submit(kind, "{}", "anna");
    EXPECT_TRUE(job) << job.error().message;
    return job ? job->id : 0;
  }
  JobState StateOf(int id) {
    const Result<JobStatus> status = queue.Find(id);
    EXPECT_TRUE(status) << status.error().message;
    return status ? status->job.state : JobState::kQueued;
  }
  /// The job once it has ended.
  Job Ended(int id) {
    std::uint64_t sequence = 0;
    for (;;) {
      const Result<JobStatus> status = queue.WaitForChange(id, sequence, kHangS, {});
      EXPECT_TRUE(status) << status.error().message;
      if (!status || HasEnded(status->job.state)) return status ? status->job : Job{};
      EXPECT_GT(status->sequence, sequence) << "the job hangs";
      if (status->sequence == sequence) return status->job;
      sequence = status->sequence;
    }
  }

  TemporaryFolder folder;
  FakeClock clock;
  std::unique_ptr<JobJournal> journal = OpenIn(folder.Path());
  JobQueue queue;
};

}  // namespace rigcal
