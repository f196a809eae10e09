#include "config/store/sqlite_store.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <sqlite3.h>

#include <cerrno>
#include <utility>

#include "config/atomic_file.h"
#include "config/json_content.h"
#include "config/new_file.h"
#include "config/provenance_json.h"
#include "config/run_report.h"
#include "config/store/sqlite_failure.h"
#include "config/store/sqlite_schema.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kHeadColumns =
    "number, rig, time, verdict, reasons, parent, seed_revision, recording_id, recording_sha256, provenance, "
    "calibration_sha256";
constexpr const char* kEventColumns = "number, rig, time, kind, revision, previous, person, reason";

/// Text that is not UTF-8 (a picture's name) does not keep a result from being stored.
std::string Dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<int> OptionalInt(const SQLite::Column& column) {
  return column.isNull() ? std::nullopt : std::optional(column.getInt());
}

void BindOptional(SQLite::Statement& statement, const char* name, const std::optional<int>& value) {
  if (value) statement.bind(name, *value);  // unbound is NULL
}

Verdict VerdictFrom(const std::string& word) {
  for (const Verdict verdict : {Verdict::kAccepted, Verdict::kRejected}) {
    if (word == NameOf(verdict)) return verdict;
  }
  return Verdict::kInconclusive;
}

/// The row of a statement that selects kHeadColumns. Throws what JSON throws.
RevisionHead HeadFrom(SQLite::Statement& row) {
  RevisionHead head;
  head.number = row.getColumn(0).getInt();
  head.rig = row.getColumn(1).getString();
  head.time = row.getColumn(2).getString();
  head.verdict = VerdictFrom(row.getColumn(3).getString());
  head.reasons = Json::parse(row.getColumn(4).getString()).get<std::vector<std::string>>();
  head.parent = OptionalInt(row.getColumn(5));
  head.origin.seed_revision = OptionalInt(row.getColumn(6));
  head.origin.recording_id = row.getColumn(7).getString();
  head.origin.recording_sha256 = row.getColumn(8).getString();
  head.origin.run = ProvenanceFrom(Json::parse(row.getColumn(9).getString()));
  head.calibration_sha256 = row.getColumn(10).getString();
  return head;
}

/// The row of a statement that selects kEventColumns.
PublishEvent EventFrom(SQLite::Statement& row) {
  PublishEvent event;
  event.number = row.getColumn(0).getInt();
  event.rig = row.getColumn(1).getString();
  event.time = row.getColumn(2).getString();
  event.kind =
      row.getColumn(3).getString() == NameOf(PublishKind::kRollback) ? PublishKind::kRollback : PublishKind::kPublish;
  event.revision = row.getColumn(4).getInt();
  event.previous = OptionalInt(row.getColumn(5));
  event.by = row.getColumn(6).getString();
  event.reason = row.getColumn(7).getString();
  return event;
}

class SqliteStore final : public CalibrationStore {
 public:
  SqliteStore(SQLite::Database database, std::filesystem::path file)
      : database_(std::move(database)), file_(std::move(file)) {}

  /// Settings of the connection, and the schema.
  Result<void> Prepare(int busy_timeout_ms);

  Result<int> Append(const CalibrationRevision& revision) override;
  Result<PublishEvent> Publish(const PublishRequest& request) override;
  Result<CalibrationRevision> Load(const std::string& rig, int number) override;
  Result<std::optional<PublishEvent>> InForce(const std::string& rig) override;
  Result<RigHistory> History(const std::string& rig) override;
  Result<std::vector<std::string>> Rigs() override;
  Result<void> Backup(const std::filesystem::path& file) override;
  Result<std::vector<std::string>> Check(const std::stop_token& stop) override;

 private:
  /// Runs `work`, turning what the libraries throw into an Error.
  template <typename Work>
  auto Guarded(const char* doing, const Work& work) -> decltype(work()) {
    errno = 0;
    try {
      return work();
    } catch (const SQLite::Exception& failure) {
      return StoreFailure(failure, errno, file_, doing);
    } catch (const Json::exception& error) {
      return Fail(ErrorCode::kIo, "{}: {} failed, a row is damaged: {}", file_.string(), doing, error.what());
    } catch (const BadContent& error) {
      return Fail(ErrorCode::kIo, "{}: {} failed, a row is damaged: {}", file_.string(), doing, error.what());
    }
  }

  Result<void> UseWriteAheadLog(int busy_timeout_ms);
  std::vector<PublishEvent> EventsOf(const std::string& rig);
  std::optional<PublishEvent> LastEventOf(const std::string& rig);
  Result<RevisionHead> HeadOf(const std::string& rig, int number);
  bool Exists(int number);
  void Insert(const PublishEvent& event);
  Result<void> CheckText(const std::string& text, const std::string& sha256, int number, const char* name) const;
  std::vector<std::string> DatabaseFindings();

  SQLite::Database database_;
  std::filesystem::path file_;
};

Result<void> SqliteStore::Prepare(int busy_timeout_ms) {
  return Guarded("opening", [&]() -> Result<void> {
    if (sqlite3_db_readonly(database_.getHandle(), "main") == 1) {
      return Fail(ErrorCode::kIo, "{}: opening failed, the file may not be written", file_.string());
    }
    database_.exec("PRAGMA foreign_keys = ON; PRAGMA synchronous = FULL");
    if (auto migrated = Migrate(database_, file_); !migrated) return migrated;
    return UseWriteAheadLog(busy_timeout_ms);
  });
}

/// A store keeps the mode once it has it. Getting there needs the file for itself, and SQLite does not always wait for
/// that by its busy time-out.
Result<void> SqliteStore::UseWriteAheadLog(int busy_timeout_ms) {
  constexpr int kPauseMs = 10;
  for (int waited_ms = 0;; waited_ms += kPauseMs) {
    try {
      const std::string mode = database_.execAndGet("PRAGMA journal_mode = WAL").getString();
      if (mode == "wal") return {};
      return Fail(ErrorCode::kUnsupported, "{}: its file system allows no write-ahead log (journal mode '{}')",
                  file_.string(), mode);
    } catch (const SQLite::Exception& failure) {
      if (failure.getErrorCode() != SQLITE_BUSY || waited_ms >= busy_timeout_ms) throw;
    }
    sqlite3_sleep(kPauseMs);
  }
}

std::vector<PublishEvent> SqliteStore::EventsOf(const std::string& rig) {
  SQLite::Statement rows(database_,
                         fmt::format("SELECT {} FROM publish_event WHERE rig = ? ORDER BY number", kEventColumns));
  rows.bind(1, rig);
  std::vector<PublishEvent> events;
  while (rows.executeStep()) events.push_back(EventFrom(rows));
  return events;
}

std::optional<PublishEvent> SqliteStore::LastEventOf(const std::string& rig) {
  SQLite::Statement row(
      database_, fmt::format("SELECT {} FROM publish_event WHERE rig = ? ORDER BY number DESC LIMIT 1", kEventColumns));
  row.bind(1, rig);
  if (!row.executeStep()) return std::nullopt;
  return EventFrom(row);
}

Result<RevisionHead> SqliteStore::HeadOf(const std::string& rig, int number) {
  SQLite::Statement row(database_, fmt::format("SELECT {} FROM revision WHERE rig = ? AND number = ?", kHeadColumns));
  row.bind(1, rig);
  row.bind(2, number);
  if (row.executeStep()) return HeadFrom(row);
  return Fail(ErrorCode::kNotFound, "{}: the rig '{}' has no revision {}", file_.string(), rig, number);
}

bool SqliteStore::Exists(int number) {
  SQLite::Statement row(database_, "SELECT 1 FROM revision WHERE number = ?");
  row.bind(1, number);
  return row.executeStep();
}

Result<int> SqliteStore::Append(const CalibrationRevision& revision) {
  const RevisionHead& head = revision.head;
  if (auto checked = CheckRevision(revision); !checked) return Fail(checked.error());
  return Guarded("storing a revision", [&]() -> Result<int> {
    SQLite::Transaction transaction(database_, SQLite::TransactionBehavior::IMMEDIATE);
    if (head.origin.seed_revision && !Exists(*head.origin.seed_revision)) {
      return Fail(ErrorCode::kNotFound, "{}: has no revision {}, which the new one is said to begin with",
                  file_.string(), *head.origin.seed_revision);
    }
    const auto last = LastEventOf(head.rig);
    SQLite::Statement insert(database_,
                             "INSERT INTO revision(rig, time, verdict, reasons, parent, seed_revision, recording_id, "
                             "recording_sha256, provenance, calibration, report, calibration_sha256, report_sha256) "
                             "VALUES(:rig, :time, :verdict, :reasons, :parent, :seed, :recording, :recording_sha256, "
                             ":provenance, :calibration, :report, :calibration_sha256, :report_sha256)");
    insert.bind(":rig", head.rig);
    insert.bind(":time", head.time);
    insert.bind(":verdict", NameOf(head.verdict));
    insert.bind(":reasons", Dumped(head.reasons));
    BindOptional(insert, ":parent", last ? std::optional(last->revision) : std::nullopt);
    BindOptional(insert, ":seed", head.origin.seed_revision);
    insert.bind(":recording", head.origin.recording_id);
    insert.bind(":recording_sha256", head.origin.recording_sha256);
    insert.bind(":provenance", Dumped(ProvenanceJson(head.origin.run)));
    insert.bind(":calibration", revision.calibration_text);
    insert.bind(":report", revision.report_text);
    insert.bind(":calibration_sha256", Sha256Hex(revision.calibration_text));
    insert.bind(":report_sha256", Sha256Hex(revision.report_text));
    insert.exec();
    const int number = static_cast<int>(database_.getLastInsertRowid());
    transaction.commit();
    return number;
  });
}

void SqliteStore::Insert(const PublishEvent& event) {
  SQLite::Statement insert(database_,
                           "INSERT INTO publish_event(rig, time, kind, revision, previous, person, reason) "
                           "VALUES(:rig, :time, :kind, :revision, :previous, :person, :reason)");
  insert.bind(":rig", event.rig);
  insert.bind(":time", event.time);
  insert.bind(":kind", NameOf(event.kind));
  insert.bind(":revision", event.revision);
  BindOptional(insert, ":previous", event.previous);
  insert.bind(":person", event.by);
  insert.bind(":reason", event.reason);
  insert.exec();
}

Result<PublishEvent> SqliteStore::Publish(const PublishRequest& request) {
  return Guarded("publishing", [&]() -> Result<PublishEvent> {
    SQLite::Transaction transaction(database_, SQLite::TransactionBehavior::IMMEDIATE);
    const Result<RevisionHead> head = HeadOf(request.rig, request.revision);
    if (!head) return Fail(head.error());
    if (auto allowed = CheckPublish(request, *head, EventsOf(request.rig)); !allowed) return Fail(allowed.error());
    PublishEvent event{.rig = request.rig,
                       .time = request.time,
                       .kind = request.kind,
                       .revision = request.revision,
                       .previous = request.expected,
                       .by = request.by,
                       .reason = request.reason};
    Insert(event);
    event.number = static_cast<int>(database_.getLastInsertRowid());
    transaction.commit();
    return event;
  });
}

Result<void> SqliteStore::CheckText(const std::string& text, const std::string& sha256, int number,
                                    const char* name) const {
  if (Sha256Hex(text) == sha256) return {};
  return Fail(ErrorCode::kIo, "{}: the {} of revision {} is damaged, its SHA-256 is no longer {}...", file_.string(),
              name, number, sha256.substr(0, 12));
}

Result<CalibrationRevision> SqliteStore::Load(const std::string& rig, int number) {
  return Guarded("reading", [&]() -> Result<CalibrationRevision> {
    Result<RevisionHead> head = HeadOf(rig, number);
    if (!head) return Fail(head.error());
    SQLite::Statement row(
        database_, "SELECT calibration, report, calibration_sha256, report_sha256 FROM revision WHERE number = ?");
    row.bind(1, number);
    row.executeStep();
    CalibrationRevision revision{std::move(*head), row.getColumn(0).getString(), row.getColumn(1).getString()};
    auto checked = CheckText(revision.calibration_text, row.getColumn(2).getString(), number, "calibration");
    if (checked) checked = CheckText(revision.report_text, row.getColumn(3).getString(), number, "report");
    if (!checked) return Fail(checked.error());
    return revision;
  });
}

Result<std::optional<PublishEvent>> SqliteStore::InForce(const std::string& rig) {
  return Guarded("reading", [&]() -> Result<std::optional<PublishEvent>> { return LastEventOf(rig); });
}

Result<RigHistory> SqliteStore::History(const std::string& rig) {
  return Guarded("reading", [&]() -> Result<RigHistory> {
    SQLite::Transaction snapshot(database_);
    RigHistory history{.events = EventsOf(rig)};
    SQLite::Statement rows(database_,
                           fmt::format("SELECT {} FROM revision WHERE rig = ? ORDER BY number", kHeadColumns));
    rows.bind(1, rig);
    while (rows.executeStep()) history.revisions.push_back(HeadFrom(rows));
    return history;
  });
}

Result<std::vector<std::string>> SqliteStore::Rigs() {
  return Guarded("reading", [&]() -> Result<std::vector<std::string>> {
    SQLite::Statement rows(database_, "SELECT DISTINCT rig FROM revision ORDER BY rig");
    std::vector<std::string> rigs;
    while (rows.executeStep()) rigs.push_back(rows.getColumn(0).getString());
    return rigs;
  });
}

Result<void> SqliteStore::Backup(const std::filesystem::path& file) {
  NewFile copy(file);
  if (auto ready = copy.Begin(); !ready) return ready;
  // VACUUM INTO writes a database of its own, without log, as of one moment; it takes an empty file for a new one.
  auto written = Guarded("the backup", [&]() -> Result<void> {
    SQLite::Statement vacuum(database_, "VACUUM INTO ?");
    vacuum.bind(1, copy.TemporaryPath().string());
    vacuum.exec();
    return {};
  });
  if (!written) return Fail(written.error().code, "{} (writing {})", written.error().message, file.string());
  return copy.Finish();
}

std::vector<std::string> SqliteStore::DatabaseFindings() {
  std::vector<std::string> findings;
  SQLite::Statement integrity(database_, "PRAGMA integrity_check");
  while (integrity.executeStep()) {
    const std::string line = integrity.getColumn(0).getString();
    if (line != "ok") findings.push_back("SQLite: " + line);
  }
  SQLite::Statement keys(database_, "PRAGMA foreign_key_check");
  while (keys.executeStep()) {
    findings.push_back(fmt::format("row {} of {} names one in {} that is not there", keys.getColumn(1).getInt64(),
                                   keys.getColumn(0).getString(), keys.getColumn(2).getString()));
  }
  for (std::string& difference : SchemaDifferences(database_)) findings.push_back(std::move(difference));
  return findings;
}

Result<std::vector<std::string>> SqliteStore::Check(const std::stop_token& stop) {
  auto findings = Guarded("checking", [&]() -> Result<std::vector<std::string>> { return DatabaseFindings(); });
  if (!findings) return findings;
  auto content = CheckContent(*this, stop);
  if (!content) return content;
  findings->insert(findings->end(), content->begin(), content->end());
  return findings;
}

Result<void> CheckPlace(const std::filesystem::path& file, bool create) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return Fail(ErrorCode::kBadInput, "{}: is a folder, the file of a calibration store is needed", file.string());
  }
  if (std::filesystem::exists(file, error)) return {};
  // Whoever may not look must not believe that nothing is there: pruning would take recordings that it needs.
  if (error) return Fail(ErrorCode::kIo, "{}: opening failed ({})", file.string(), error.message());
  if (!create) return Fail(ErrorCode::kNotFound, "{}: there is no calibration store", file.string());
  return PrepareOutputFolder(file.has_parent_path() ? file.parent_path() : ".");
}

}  // namespace

Result<std::unique_ptr<CalibrationStore>> OpenSqliteStore(const std::filesystem::path& file,
                                                          const SqliteStoreOptions& options) {
  if (auto ready = CheckPlace(file, options.create); !ready) return Fail(ready.error());
  const int flags = SQLite::OPEN_READWRITE | (options.create ? SQLite::OPEN_CREATE : 0);
  errno = 0;
  try {
    auto store = std::make_unique<SqliteStore>(SQLite::Database(file.string(), flags, options.busy_timeout_ms), file);
    if (auto prepared = store->Prepare(options.busy_timeout_ms); !prepared) return Fail(prepared.error());
    return store;
  } catch (const SQLite::Exception& failure) {
    return StoreFailure(failure, errno, file, "opening");
  }
}

}  // namespace rigcal
