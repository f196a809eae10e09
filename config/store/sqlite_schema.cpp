#include "config/store/sqlite_schema.h"

#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>

#include <array>
#include <cstdint>
#include <map>

#include "config/read_file.h"

namespace rigcal {
namespace {

constexpr int kApplicationId = 0x7267636c;  // "rgcl": tells a store from other SQLite databases

/// 1: revisions, and a pointer that is overwritten.
constexpr const char* kSchema1 = R"(
CREATE TABLE revision(
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  rig TEXT NOT NULL CHECK(rig <> ''),
  time TEXT NOT NULL CHECK(time GLOB '[0-9][0-9][0-9][0-9]-[0-9][0-9]-[0-9][0-9]T*Z'),
  verdict TEXT NOT NULL CHECK(verdict IN ('accepted', 'rejected', 'inconclusive')),
  reasons TEXT NOT NULL CHECK(json_valid(reasons)),
  parent INTEGER REFERENCES revision(number),
  seed_revision INTEGER REFERENCES revision(number),
  recording_id TEXT NOT NULL,
  recording_sha256 TEXT NOT NULL,
  provenance TEXT NOT NULL CHECK(json_valid(provenance)),
  calibration TEXT NOT NULL,
  report TEXT NOT NULL
) STRICT;
CREATE UNIQUE INDEX revision_of_rig ON revision(rig, number);
CREATE TABLE in_force(
  rig TEXT PRIMARY KEY,
  revision INTEGER NOT NULL REFERENCES revision(number),
  time TEXT NOT NULL,
  person TEXT NOT NULL
) STRICT;
)";

/// 2: every move of the pointer is kept and the last one is the pointer; texts have checksums; nothing can be changed
/// or removed, not even by another program's SQL. INSERT is guarded as well because INSERT OR REPLACE deletes without
/// firing the trigger of DELETE.
constexpr const char* kSchema2 = R"(
CREATE TABLE publish_event(
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  rig TEXT NOT NULL,
  time TEXT NOT NULL CHECK(time GLOB '[0-9][0-9][0-9][0-9]-[0-9][0-9]-[0-9][0-9]T*Z'),
  kind TEXT NOT NULL CHECK(kind IN ('publish', 'rollback')),
  revision INTEGER NOT NULL,
  previous INTEGER REFERENCES revision(number),
  person TEXT NOT NULL,
  reason TEXT NOT NULL,
  FOREIGN KEY(rig, revision) REFERENCES revision(rig, number)
) STRICT;
CREATE INDEX publish_event_of_rig ON publish_event(rig, number);
INSERT INTO publish_event(rig, time, kind, revision, previous, person, reason)
  SELECT rig, time, 'publish', revision, NULL, person, 'in force when the store was brought to schema 2'
  FROM in_force ORDER BY rig;
DROP TABLE in_force;
ALTER TABLE revision ADD COLUMN calibration_sha256 TEXT NOT NULL DEFAULT '';
ALTER TABLE revision ADD COLUMN report_sha256 TEXT NOT NULL DEFAULT '';
)";
constexpr const char* kSchema2Triggers = R"(
CREATE TRIGGER revision_is_not_changed BEFORE UPDATE ON revision
  BEGIN SELECT RAISE(ABORT, 'a revision is never changed'); END;
CREATE TRIGGER revision_is_not_removed BEFORE DELETE ON revision
  BEGIN SELECT RAISE(ABORT, 'a revision is never removed'); END;
CREATE TRIGGER revision_is_not_replaced BEFORE INSERT ON revision
  WHEN EXISTS(SELECT 1 FROM revision WHERE number = NEW.number)
  BEGIN SELECT RAISE(ABORT, 'a revision is never replaced'); END;
CREATE TRIGGER publish_event_is_not_changed BEFORE UPDATE ON publish_event
  BEGIN SELECT RAISE(ABORT, 'a publish event is never changed'); END;
CREATE TRIGGER publish_event_is_not_removed BEFORE DELETE ON publish_event
  BEGIN SELECT RAISE(ABORT, 'a publish event is never removed'); END;
CREATE TRIGGER publish_event_is_not_replaced BEFORE INSERT ON publish_event
  WHEN EXISTS(SELECT 1 FROM publish_event WHERE number = NEW.number)
  BEGIN SELECT RAISE(ABORT, 'a publish event is never replaced'); END;
CREATE TRIGGER publish_event_follows BEFORE INSERT ON publish_event
  WHEN NEW.previous IS NOT (SELECT revision FROM publish_event WHERE rig = NEW.rig ORDER BY number DESC LIMIT 1)
  BEGIN SELECT RAISE(ABORT, 'a publish event begins with what is in force'); END;
)";

void AddChecksums(SQLite::Database& database) {
  std::vector<std::int64_t> numbers;
  SQLite::Statement all(database, "SELECT number FROM revision");
  while (all.executeStep()) numbers.push_back(all.getColumn(0).getInt64());
  for (const std::int64_t number : numbers) {
    SQLite::Statement texts(database, "SELECT calibration, report FROM revision WHERE number = ?");
    texts.bind(1, number);
    texts.executeStep();
    SQLite::Statement update(database,
                             "UPDATE revision SET calibration_sha256 = ?, report_sha256 = ? WHERE number = ?");
    update.bind(1, Sha256Hex(texts.getColumn(0).getString()));
    update.bind(2, Sha256Hex(texts.getColumn(1).getString()));
    update.bind(3, number);
    update.exec();
  }
}

void ToSchema1(SQLite::Database& database) {
  database.exec(kSchema1);
}

void ToSchema2(SQLite::Database& database) {
  database.exec(kSchema2);
  AddChecksums(database);
  database.exec(kSchema2Triggers);
}

/// Step i brings schema i to i + 1.
constexpr std::array<void (*)(SQLite::Database&), kStoreSchema> kSteps = {ToSchema1, ToSchema2};

int Pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(std::string("PRAGMA ") + name).getInt();
}

/// What it is made of: "trigger revision_is_not_changed" -> its SQL.
std::map<std::string, std::string> SchemaOf(SQLite::Database& database) {
  SQLite::Statement rows(database, "SELECT type || ' ' || name, sql FROM sqlite_master WHERE sql IS NOT NULL");
  std::map<std::string, std::string> schema;
  while (rows.executeStep()) schema.emplace(rows.getColumn(0).getString(), rows.getColumn(1).getString());
  return schema;
}

}  // namespace

Result<void> Migrate(SQLite::Database& database, const std::filesystem::path& file) {
  if (Pragma(database, "user_version") == kStoreSchema && Pragma(database, "application_id") == kApplicationId) {
    return {};
  }
  // The schema is looked at again under the lock: another program may be bringing the same store up to date.
  SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
  const int version = Pragma(database, "user_version"), application = Pragma(database, "application_id");
  const bool is_empty = version == 0 && application == 0 && SchemaOf(database).empty();
  if (!is_empty && application != kApplicationId) {
    return Fail(ErrorCode::kBadInput, "{}: is a database, but no calibration store of rigcal", file.string());
  }
  if (version > kStoreSchema) {
    return Fail(ErrorCode::kUnsupported, "{}: has schema {}, this program knows up to {}; use a newer rigcal",
                file.string(), version, kStoreSchema);
  }
  for (int step = version; step < kStoreSchema; ++step) kSteps[step](database);
  database.exec(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kStoreSchema));
  transaction.commit();
  return {};
}

std::vector<std::string> SchemaDifferences(SQLite::Database& database) {
  SQLite::Database fresh(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  for (const auto step : kSteps) step(fresh);
  const auto expected = SchemaOf(fresh), actual = SchemaOf(database);
  std::vector<std::string> differences;
  for (const auto& [name, sql] : expected) {
    const auto found = actual.find(name);
    if (found == actual.end()) differences.push_back(fmt::format("the {} is missing", name));
    if (found != actual.end() && found->second != sql) differences.push_back(fmt::format("the {} was changed", name));
  }
  for (const auto& [name, sql] : actual) {
    if (!expected.contains(name)) differences.push_back(fmt::format("the {} does not belong there", name));
  }
  return differences;
}

}  // namespace rigcal
