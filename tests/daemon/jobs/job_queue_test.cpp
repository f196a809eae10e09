#include "daemon/jobs/job_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/daemon/jobs/scripted_jobs.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

JobProgress At(const std::string& stage, double share) {
  return {.run = {.stage = stage, .stage_share = share}};
}

TEST(JobQueue, AJobIsInTheJournalBeforeItBegins) {
  QueueBench bench;
  const int id = bench.Submit();
  EXPECT_EQ(bench.journal->Load(id)->state, JobState::kQueued);
  const auto begun = bench.queue.TakeNext();
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun->job.id, id);
  const auto kept = bench.journal->Load(id);
  EXPECT_EQ(kept->state, JobState::kRunning);
  EXPECT_EQ(kept->begun_at, QueueBench::Now());
  ASSERT_TRUE(bench.queue.SetRecording(id, "/recordings/1"));
  EXPECT_EQ(bench.journal->Load(id)->recording, "/recordings/1");
  bench.queue.End(id, JobOutcome{.revision = 4, .message = "revision 4: accepted", .exit_status = kJobAccepted});
  const auto ended = bench.journal->Load(id);
  EXPECT_EQ(ended->state, JobState::kDone);
  EXPECT_EQ(ended->outcome.revision, 4);
  EXPECT_EQ(ended->outcome.exit_status, kJobAccepted);
  EXPECT_FALSE(bench.queue.Running());
}

TEST(JobQueue, JobsAreTakenInTheirOrderAndNoMoreWaitThanMay) {
  QueueBench bench({.max_waiting = 2});
  const int first = bench.Submit(), second = bench.Submit();
  const Result<Job> refused = bench.queue.Submit("capture", "{}", "anna");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kConflict);
  EXPECT_THAT(refused.error().message, HasSubstr("2 jobs are waiting, no more than 2 may"));
  EXPECT_EQ(bench.queue.TakeNext()->job.id, first);
  bench.Submit();
  bench.queue.End(first, Fail(ErrorCode::kDevice, "camera 'left' is gone"));
  EXPECT_EQ(bench.StateOf(first), JobState::kFailed);
  EXPECT_EQ(bench.queue.TakeNext()->job.id, second);
}

TEST(JobQueue, AJobThatWaitsIsCancelledAtOnce) {
  QueueBench bench;
  const int first = bench.Submit(), second = bench.Submit();
  ASSERT_TRUE(bench.queue.Cancel(first));
  EXPECT_EQ(bench.StateOf(first), JobState::kCancelled);
  EXPECT_EQ(bench.journal->Load(first)->state, JobState::kCancelled);
  EXPECT_EQ(bench.queue.TakeNext()->job.id, second);
  EXPECT_EQ(bench.queue.Cancel(first).error().code, ErrorCode::kConflict);
  EXPECT_EQ(bench.queue.Cancel(99).error().code, ErrorCode::kNotFound);
}

TEST(JobQueue, AJobThatRunsIsAskedToStopAndIsWatchedUntilItDoes) {
  QueueBench bench;
  const int id = bench.Submit();
  const auto begun = bench.queue.TakeNext();
  EXPECT_FALSE(bench.queue.StoppingForS());
  const auto status = bench.queue.Cancel(id);
  ASSERT_TRUE(status);
  EXPECT_TRUE(status->cancel_requested);
  EXPECT_TRUE(begun->stop.stop_requested());
  bench.clock.Advance(5);
  EXPECT_EQ(bench.queue.StoppingForS(), 5);
  bench.queue.End(id, Fail(ErrorCode::kCancelled, "stereo was stopped on request"));
  EXPECT_EQ(bench.StateOf(id), JobState::kCancelled);
  EXPECT_FALSE(bench.queue.StoppingForS());
}

TEST(JobQueue, AJobThatEndsBeforeItSeesTheCancelIsDone) {
  QueueBench bench;
  const int id = bench.Submit();
  bench.queue.TakeNext();
  ASSERT_TRUE(bench.queue.Cancel(id));
  bench.queue.End(id, JobOutcome{.message = "revision 1: accepted", .exit_status = kJobAccepted});
  EXPECT_EQ(bench.StateOf(id), JobState::kDone);
}

TEST(JobQueue, ClosingInterruptsWhatWaitsAndStopsWhatRuns) {
  QueueBench bench;
  const int first = bench.Submit(), second = bench.Submit();
  const auto begun = bench.queue.TakeNext();
  bench.queue.Close();
  EXPECT_TRUE(begun->stop.stop_requested());
  EXPECT_EQ(bench.StateOf(second), JobState::kInterrupted);
  EXPECT_FALSE(bench.queue.TakeNext());
  EXPECT_EQ(bench.queue.Submit("capture", "{}", "anna").error().code, ErrorCode::kConflict);
  bench.queue.End(first, Fail(ErrorCode::kCancelled, "stopped"));
  EXPECT_EQ(bench.StateOf(first), JobState::kInterrupted);
}

TEST(JobQueue, ProgressIsToldWhenTheStageChangesAndElseNotTooOften) {
  QueueBench bench({.report_every_s = 0.5});
  const int id = bench.Submit();
  bench.queue.TakeNext();
  bench.clock.Advance(1);
  const auto sequence = [&] { return bench.queue.Find(id)->sequence; };
  bench.queue.Report(id, At("stereo", 0));
  const std::uint64_t first = sequence();
  bench.queue.Report(id, At("stereo", 0.1));
  EXPECT_EQ(sequence(), first);
  bench.queue.Report(id, At("match", 0));
  EXPECT_EQ(sequence(), first + 1);
  bench.clock.Advance(0.5);
  bench.queue.Report(id, At("match", 0.7));
  EXPECT_EQ(sequence(), first + 2);
  EXPECT_EQ(bench.queue.Find(id)->progress->run.stage_share, 0.7);
  bench.queue.End(id, JobOutcome{});
  EXPECT_FALSE(bench.queue.Find(id)->progress);
}

TEST(JobQueue, ListenersWakeUpForTheirJobAndForTheEnd) {
  QueueBench bench;
  const int id = bench.Submit();
  const std::uint64_t seen = bench.queue.Find(id)->sequence;
  EXPECT_EQ(bench.queue.WaitForChange(id, seen - 1, kHangS, {})->sequence, seen) << "what was missed is told at once";
  std::jthread worker([&] { bench.queue.TakeNext(); });
  const auto status = bench.queue.WaitForChange(id, seen, kHangS, {});
  ASSERT_TRUE(status);
  EXPECT_EQ(status->job.state, JobState::kRunning);
  worker.join();
  std::stop_source gone;
  gone.request_stop();
  EXPECT_EQ(bench.queue.WaitForChange(id, status->sequence, kHangS, gone.get_token()).error().code,
            ErrorCode::kCancelled);
  std::jthread closer([&] { bench.queue.Close(); });
  EXPECT_EQ(bench.queue.WaitForChange(id, status->sequence, kHangS, {}).error().code, ErrorCode::kCancelled);
}

TEST(JobQueue, EndedJobsAreForgottenHereAndStayInTheJournal) {
  QueueBench bench({.max_ended = 1});
  for (int i = 0; i < 3; ++i) {
    const int id = bench.Submit();
    bench.queue.TakeNext();
    bench.queue.End(id, JobOutcome{.message = "done"});
  }
  EXPECT_EQ(bench.queue.Find(1)->sequence, 0U) << "from the journal";
  EXPECT_GT(bench.queue.Find(3)->sequence, 0U);
  EXPECT_EQ(bench.StateOf(1), JobState::kDone);
  EXPECT_EQ(bench.queue.WaitForChange(1, 0, kHangS, {})->job.outcome.message, "done");
  EXPECT_EQ(bench.queue.Newest(10)->size(), 3U);
}

TEST(JobProgress, TellsTheTimeLeftOnceThatIsMoreThanAGuess) {
  RunProgress progress{.stage = "stereo", .round = 1, .num_rounds = 4, .stage_share = 0.5, .run_share = 0.01};
  EXPECT_FALSE(TimeLeftS(progress, 10));
  progress.run_share = 0.25;
  EXPECT_DOUBLE_EQ(*TimeLeftS(progress, 10), 30);
  EXPECT_EQ(ProgressText({progress, 30}), "stereo, round 2 of 4: 25 %, about 30 s left");
  EXPECT_EQ(ProgressText({{.stage = "detect", .stage_share = 0.5}, {}}), "detect: 50 %");
}

}  // namespace
}  // namespace rigcal
