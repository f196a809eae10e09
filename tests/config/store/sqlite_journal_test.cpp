#include "config/store/sqlite_journal.h"

#include <SQLiteCpp/Database.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

Job Example() {
  return {.kind = "recalibrate", .request = R"({"rounds":2})", .by = "anna", .queued_at = "2026-02-01T06:00:00Z"};
}

void ExpectSame(const Job& a, const Job& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.request, b.request);
  EXPECT_EQ(a.by, b.by);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.queued_at, b.queued_at);
  EXPECT_EQ(a.begun_at, b.begun_at);
  EXPECT_EQ(a.ended_at, b.ended_at);
  EXPECT_EQ(a.recording, b.recording);
  EXPECT_EQ(a.outcome.verdict, b.outcome.verdict);
  EXPECT_EQ(a.outcome.revision, b.outcome.revision);
  EXPECT_EQ(a.outcome.message, b.outcome.message);
  EXPECT_EQ(a.outcome.exit_status, b.outcome.exit_status);
}

class SqliteJournal : public ::testing::Test {
 protected:
  std::unique_ptr<JobJournal> Open() {
    auto journal = OpenSqliteJournal(file_);
    EXPECT_TRUE(journal) << journal.error().message;
    return std::move(*journal);
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.Path() / "state" / kJournalFile;
};

TEST_F(SqliteJournal, KeepsEveryFieldForAnotherProgram) {
  Job job = Example();
  {
    const auto journal = Open();
    job.id = *journal->Append(job);
    job.state = JobState::kDone;
    job.begun_at = "2026-02-01T06:00:01Z";
    job.ended_at = "2026-02-01T06:10:00Z";
    job.recording = "/var/lib/rigcal/recordings/night";
    job.outcome = {.verdict = Verdict::kRejected, .revision = 7, .message = "revision 7: rejected", .exit_status = 3};
    ASSERT_TRUE(journal->Update(job));
  }
  const auto loaded = Open()->Load(job.id);
  ASSERT_TRUE(loaded) << loaded.error().message;
  ExpectSame(*loaded, job);
}

TEST_F(SqliteJournal, ListsTheNewestFirst) {
  const auto journal = Open();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(journal->Append(Example()));
  const auto jobs = journal->Newest(2);
  ASSERT_TRUE(jobs);
  ASSERT_EQ(jobs->size(), 2U);
  EXPECT_EQ(jobs->at(0).id, 3);
  EXPECT_EQ(jobs->at(1).id, 2);
  EXPECT_EQ(journal->Load(9).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(journal->Update({.id = 9, .kind = "capture", .request = "{}"}).error().code, ErrorCode::kNotFound);
}

TEST_F(SqliteJournal, OfAKilledServiceHasNoJobThatStillRuns) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto journal = OpenSqliteJournal(file_);
    Job job = Example();
    for (int i = 0; i < 3; ++i) job.id = *(*journal)->Append(job);
    job.id = 1;
    job.state = JobState::kDone;
    if (!(*journal)->Update(job)) _exit(1);
    job.id = 2;
    job.state = JobState::kRunning;
    job.recording = "/recordings/2";
    if (!(*journal)->Update(job)) _exit(1);
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const auto journal = Open();
  const auto interrupted = journal->InterruptUnfinished("2026-02-01T07:00:00Z");
  ASSERT_TRUE(interrupted);
  ASSERT_EQ(interrupted->size(), 2U);
  EXPECT_EQ(interrupted->at(0).id, 2);
  EXPECT_THAT(interrupted->at(0).outcome.message, HasSubstr("while the job ran"));
  EXPECT_THAT(interrupted->at(1).outcome.message, HasSubstr("before the job began"));
  const auto kept = journal->Load(2);
  EXPECT_EQ(kept->state, JobState::kInterrupted);
  EXPECT_EQ(kept->recording, "/recordings/2");
  EXPECT_EQ(kept->ended_at, "2026-02-01T07:00:00Z");
  EXPECT_EQ(journal->Load(1)->state, JobState::kDone);
  EXPECT_TRUE(journal->InterruptUnfinished("2026-02-01T08:00:00Z")->empty());
}

TEST_F(SqliteJournal, RefusesWhatIsNone) {
  folder_.Write("text.sqlite", "this is no database, and long enough to be sure of that");
  EXPECT_EQ(OpenSqliteJournal(folder_.Path() / "text.sqlite").error().code, ErrorCode::kBadInput);
  SQLite::Database((folder_.Path() / "other.sqlite").string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("CREATE TABLE a(b)");
  EXPECT_THAT(OpenSqliteJournal(folder_.Path() / "other.sqlite").error().message, HasSubstr("no journal of rigcald"));
  Open();
  SQLite::Database(file_.string(), SQLite::OPEN_READWRITE).exec("PRAGMA user_version = 99");
  EXPECT_EQ(OpenSqliteJournal(file_).error().code, ErrorCode::kUnsupported);
}

TEST(JobStates, HaveNamesThatReadBack) {
  for (const JobState state : {JobState::kQueued, JobState::kRunning, JobState::kDone, JobState::kFailed,
                               JobState::kCancelled, JobState::kInterrupted}) {
    EXPECT_EQ(JobStateFromName(NameOf(state)), state);
    EXPECT_EQ(HasEnded(state), state != JobState::kQueued && state != JobState::kRunning);
  }
  EXPECT_FALSE(JobStateFromName("succeeded"));
}

}  // namespace
}  // namespace rigcal
