#include "daemon/jobs/worker.h"

#include <SQLiteCpp/Database.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "core/base/ensure.h"
#include "tests/daemon/jobs/scripted_jobs.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Waits for the stop token as a stage does, without a limit of its own.
Result<JobOutcome> UntilStopped(JobHandle& handle, Event& began) {
  Event stopped;
  const std::stop_callback on_stop(handle.Stop(), [&] { stopped.Happen(); });
  began.Happen();
  EXPECT_TRUE(stopped.Await());
  return Fail(ErrorCode::kCancelled, "the job was stopped on request");
}

TEST(Worker, RunsOneJobAfterTheOther) {
  QueueBench bench;
  std::vector<std::string> ran;
  std::vector<int> told;
  std::optional<Worker> worker;
  worker.emplace(
      bench.queue, bench.clock,
      [&](JobHandle& handle) -> Result<JobOutcome> {
        ran.push_back(handle.Content().kind);
        return JobOutcome{.message = "well", .exit_status = kJobAccepted};
      },
      [&](const Job& job) { told.push_back(job.id); });
  const int first = bench.Submit("capture"), second = bench.Submit("replay");
  EXPECT_EQ(bench.Ended(second).outcome.message, "well");
  EXPECT_EQ(bench.StateOf(first), JobState::kDone);
  worker.reset();
  EXPECT_THAT(ran, ElementsAre("capture", "replay"));
  EXPECT_THAT(told, ElementsAre(first, second));
}

TEST(Worker, ABugFailsItsJobAndTheNextOneRuns) {
  QueueBench bench;
  const Worker worker(bench.queue, bench.clock,
                      [](JobHandle& handle) -> Result<JobOutcome> {
                        Ensure(handle.Content().kind != "bug", "a promise that is broken");
                        return JobOutcome{.message = "well"};
                      },
                      {});
  const int bug = bench.Submit("bug"), next = bench.Submit("capture");
  EXPECT_EQ(bench.Ended(next).state, JobState::kDone);
  const Job failed = bench.Ended(bug);
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_EQ(failed.outcome.exit_status, kJobFailed);
  EXPECT_THAT(failed.outcome.message, HasSubstr("internal error: "));
  EXPECT_THAT(failed.outcome.message, HasSubstr("a promise that is broken"));
}

TEST(Worker, ACancelledJobStopsAndTheNextOneRuns) {
  QueueBench bench;
  Event began;
  const Worker worker(bench.queue, bench.clock,
                      [&](JobHandle& handle) -> Result<JobOutcome> {
                        if (handle.Content().kind == "long") return UntilStopped(handle, began);
                        return JobOutcome{};
                      },
                      {});
  const int id = bench.Submit("long"), next = bench.Submit("short");
  ASSERT_TRUE(began.Await());
  ASSERT_TRUE(bench.queue.Cancel(id));
  EXPECT_EQ(bench.Ended(id).state, JobState::kCancelled);
  EXPECT_EQ(bench.Ended(next).state, JobState::kDone);
}

TEST(Worker, TheEndOfTheServiceInterruptsTheJobThatRuns) {
  QueueBench bench;
  Event began;
  std::optional<Worker> worker;
  worker.emplace(
      bench.queue, bench.clock, [&](JobHandle& handle) { return UntilStopped(handle, began); },
      std::function<void(const Job&)>());
  const int id = bench.Submit();
  ASSERT_TRUE(began.Await());
  worker.reset();
  EXPECT_EQ(bench.StateOf(id), JobState::kInterrupted);
  EXPECT_EQ(bench.journal->Load(id)->state, JobState::kInterrupted);
}

TEST(Worker, AJobThatTheJournalCannotHoldIsNotBegun) {
  QueueBench bench;
  std::atomic<int> ran = 0;
  const int id = bench.Submit();
  // Another program holds the journal for longer than anybody waits.
  SQLite::Database other((bench.folder.Path() / kJournalFile).string(), SQLite::OPEN_READWRITE);
  other.exec("BEGIN IMMEDIATE");
  const Worker worker(bench.queue, bench.clock,
                      [&](JobHandle&) -> Result<JobOutcome> {
                        ++ran;
                        return JobOutcome{};
                      },
                      {});
  const Job job = bench.Ended(id);
  other.exec("ROLLBACK");
  EXPECT_EQ(job.state, JobState::kFailed);
  EXPECT_THAT(job.outcome.message, HasSubstr("not begun: "));
  EXPECT_EQ(ran, 0);
}

TEST(Worker, TellsTheTimeThatIsLeft) {
  QueueBench bench;
  Event reported, seen;
  const Worker worker(bench.queue, bench.clock,
                      [&](JobHandle& handle) -> Result<JobOutcome> {
                        const auto listener = handle.Listener();
                        bench.clock.Advance(10);
                        listener({.stage = "stereo", .round = 0, .num_rounds = 4, .run_share = 0.5});
                        reported.Happen();
                        EXPECT_TRUE(seen.Await());
                        return JobOutcome{};
                      },
                      {});
  const int id = bench.Submit();
  ASSERT_TRUE(reported.Await());
  const auto status = bench.queue.Find(id);
  ASSERT_TRUE(status->progress);
  EXPECT_DOUBLE_EQ(status->progress->left_s.value_or(0), 10);
  seen.Happen();
  EXPECT_EQ(bench.Ended(id).state, JobState::kDone);
}

}  // namespace
}  // namespace rigcal
