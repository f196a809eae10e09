#include "config/store/sqlite_journal.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>

#include <cerrno>
#include <utility>

#include "config/atomic_file.h"
#include "config/run_report.h"
#include "config/store/sqlite_failure.h"

namespace rigcal {
namespace {

constexpr int kApplicationId = 0x72676a62;  // "rgjb": tells a journal from other SQLite databases
constexpr int kJournalSchema = 1;           // PRAGMA user_version
constexpr int kBusyTimeoutMs = 1500;        // as the calibration store's

constexpr const char* kSchema = R"(
CREATE TABLE job(
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind TEXT NOT NULL CHECK(kind <> ''),
  request TEXT NOT NULL CHECK(json_valid(request)),
  person TEXT NOT NULL,
  state TEXT NOT NULL CHECK(state IN ('queued', 'running', 'done', 'failed', 'cancelled', 'interrupted')),
  queued_at TEXT NOT NULL,
  begun_at TEXT NOT NULL,
  ended_at TEXT NOT NULL,
  recording TEXT NOT NULL,
  verdict TEXT CHECK(verdict IN ('accepted', 'rejected', 'inconclusive')),
  revision INTEGER,
  message TEXT NOT NULL,
  exit_status INTEGER NOT NULL
) STRICT;
CREATE INDEX job_by_state ON job(state);
)";

constexpr const char* kColumns =
    "id, kind, request, person, state, queued_at, begun_at, ended_at, recording, verdict, revision, message, "
    "exit_status";

std::optional<Verdict> VerdictOf(const SQLite::Column& column) {
  if (column.isNull()) return std::nullopt;
  for (const Verdict verdict : {Verdict::kAccepted, Verdict::kRejected}) {
    if (column.getString() == NameOf(verdict)) return verdict;
  }
  return Verdict::kInconclusive;
}

/// The row of a statement that selects kColumns.
Job JobFrom(SQLite::Statement& row) {
  Job job;
  job.id = row.getColumn(0).getInt();
  job.kind = row.getColumn(1).getString();
  job.request = row.getColumn(2).getString();
  job.by = row.getColumn(3).getString();
  job.state = JobStateFromName(row.getColumn(4).getString()).value_or(JobState::kInterrupted);
  job.queued_at = row.getColumn(5).getString();
  job.begun_at = row.getColumn(6).getString();
  job.ended_at = row.getColumn(7).getString();
  job.recording = row.getColumn(8).getString();
  job.outcome.verdict = VerdictOf(row.getColumn(9));
  if (!row.getColumn(10).isNull()) job.outcome.revision = row.getColumn(10).getInt();
  job.outcome.message = row.getColumn(11).getString();
  job.outcome.exit_status = row.getColumn(12).getInt();
  return job;
}

/// What changes in the life of a job.
void BindState(SQLite::Statement& statement, const Job& job) {
  statement.bind(":state", NameOf(job.state));
  statement.bind(":begun_at", job.begun_at);
  statement.bind(":ended_at", job.ended_at);
  statement.bind(":recording", job.recording);
  if (job.outcome.verdict) statement.bind(":verdict", NameOf(*job.outcome.verdict));  // unbound is NULL
  if (job.outcome.revision) statement.bind(":revision", *job.outcome.revision);
  statement.bind(":message", job.outcome.message);
  statement.bind(":exit_status", job.outcome.exit_status);
}

class SqliteJournal final : public JobJournal {
 public:
  SqliteJournal(SQLite::Database database, std::filesystem::path file)
      : database_(std::move(database)), file_(std::move(file)) {}

  Result<void> Prepare();
  Result<int> Append(const Job& job) override;
  Result<void> Update(const Job& job) override;
  Result<Job> Load(int id) override;
  Result<std::vector<Job>> Newest(int count) override;
  Result<std::vector<Job>> InterruptUnfinished(const std::string& now) override;

 private:
  /// Runs `work`, turning what the library throws into an Error.
  template <typename Work>
  auto Guarded(const char* doing, const Work& work) -> decltype(work()) {
    errno = 0;
    try {
      return work();
    } catch (const SQLite::Exception& failure) {
      return StoreFailure(failure, errno, file_, doing);
    }
  }

  int Pragma(const char* name) { return database_.execAndGet(std::string("PRAGMA ") + name).getInt(); }
  Result<void> Migrate();
  void Write(const Job& job);

  SQLite::Database database_;
  std::filesystem::path file_;
};

Result<void> SqliteJournal::Migrate() {
  SQLite::Transaction transaction(database_, SQLite::TransactionBehavior::IMMEDIATE);
  const int version = Pragma("user_version"), application = Pragma("application_id");
  if (application == kApplicationId && version == kJournalSchema) return {};
  if (application == kApplicationId && version > kJournalSchema) {
    return Fail(ErrorCode::kUnsupported, "{}: has schema {}, this program knows up to {}; use a newer rigcal",
                file_.string(), version, kJournalSchema);
  }
  if (application != 0 || version != 0 || database_.execAndGet("SELECT count(*) FROM sqlite_master").getInt() != 0) {
    return Fail(ErrorCode::kBadInput, "{}: is a database, but no journal of rigcald", file_.string());
  }
  database_.exec(kSchema);
  database_.exec(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kJournalSchema));
  transaction.commit();
  return {};
}

Result<void> SqliteJournal::Prepare() {
  return Guarded("opening", [&]() -> Result<void> {
    if (auto migrated = Migrate(); !migrated) return migrated;
    database_.exec("PRAGMA synchronous = FULL; PRAGMA journal_mode = WAL");
    return {};
  });
}

Result<int> SqliteJournal::Append(const Job& job) {
  return Guarded("writing a job", [&]() -> Result<int> {
    SQLite::Statement insert(database_,
                             "INSERT INTO job(kind, request, person, state, queued_at, begun_at, ended_at, recording, "
                             "verdict, revision, message, exit_status) VALUES(:kind, :request, :person, :state, "
                             ":queued_at, :begun_at, :ended_at, :recording, :verdict, :revision, :message, "
                             ":exit_status)");
    insert.bind(":kind", job.kind);
    insert.bind(":request", job.request);
    insert.bind(":person", job.by);
    insert.bind(":queued_at", job.queued_at);
    BindState(insert, job);
    insert.exec();
    return static_cast<int>(database_.getLastInsertRowid());
  });
}

void SqliteJournal::Write(const Job& job) {
  SQLite::Statement update(database_,
                           "UPDATE job SET state = :state, begun_at = :begun_at, ended_at = :ended_at, recording = "
                           ":recording, verdict = :verdict, revision = :revision, message = :message, exit_status = "
                           ":exit_status WHERE id = :id");
  update.bind(":id", job.id);
  BindState(update, job);
  update.exec();
}

Result<void> SqliteJournal::Update(const Job& job) {
  return Guarded("writing a job", [&]() -> Result<void> {
    Write(job);
    if (database_.getChanges() == 1) return {};
    return Fail(ErrorCode::kNotFound, "{}: has no job {}", file_.string(), job.id);
  });
}

Result<Job> SqliteJournal::Load(int id) {
  return Guarded("reading", [&]() -> Result<Job> {
    SQLite::Statement row(database_, fmt::format("SELECT {} FROM job WHERE id = ?", kColumns));
    row.bind(1, id);
    if (row.executeStep()) return JobFrom(row);
    return Fail(ErrorCode::kNotFound, "{}: has no job {}", file_.string(), id);
  });
}

Result<std::vector<Job>> SqliteJournal::Newest(int count) {
  return Guarded("reading", [&]() -> Result<std::vector<Job>> {
    SQLite::Statement rows(database_, fmt::format("SELECT {} FROM job ORDER BY id DESC LIMIT ?", kColumns));
    rows.bind(1, count);
    std::vector<Job> jobs;
    while (rows.executeStep()) jobs.push_back(JobFrom(rows));
    return jobs;
  });
}

Result<std::vector<Job>> SqliteJournal::InterruptUnfinished(const std::string& now) {
  return Guarded("reading", [&]() -> Result<std::vector<Job>> {
    SQLite::Transaction transaction(database_, SQLite::TransactionBehavior::IMMEDIATE);
    std::vector<Job> jobs;
    SQLite::Statement rows(
        database_, fmt::format("SELECT {} FROM job WHERE state IN ('queued', 'running') ORDER BY id", kColumns));
    while (rows.executeStep()) jobs.push_back(JobFrom(rows));
    rows.reset();
    for (Job& job : jobs) {
      const bool began = job.state == JobState::kRunning;
      job.state = JobState::kInterrupted;
      job.ended_at = now;
      job.outcome.message = began ? "the service ended while the job ran" : "the service ended before the job began";
      Write(job);
    }
    transaction.commit();
    return jobs;
  });
}

}  // namespace

Result<std::unique_ptr<JobJournal>> OpenSqliteJournal(const std::filesystem::path& file) {
  if (auto ready = PrepareOutputFolder(file.has_parent_path() ? file.parent_path() : "."); !ready) {
    return Fail(ready.error());
  }
  errno = 0;
  try {
    auto journal = std::make_unique<SqliteJournal>(
        SQLite::Database(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, kBusyTimeoutMs), file);
    if (auto prepared = journal->Prepare(); !prepared) return Fail(prepared.error());
    return journal;
  } catch (const SQLite::Exception& failure) {
    return StoreFailure(failure, errno, file, "opening");
  }
}

}  // namespace rigcal
