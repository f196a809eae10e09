#include "config/store/sqlite_store.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <fcntl.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "tests/config/store_contract.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

INSTANTIATE_TEST_SUITE_P(Sqlite, StoreContract,
                         ::testing::Values(StoreKind{
                             "sqlite",
                             [](const std::filesystem::path& folder) {
                               // On a busy machine a sync of the disk may take seconds.
                               return OpenSqliteStore(folder / kStoreFile, {.create = true, .busy_timeout_ms = 60'000});
                             },
                             [](const std::filesystem::path& file) { return OpenSqliteStore(file); }}),
                         [](const auto& kind) { return kind.param.name; });

const int kOpenForWriting = SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE;

class SqliteStoreFile : public ::testing::Test {
 protected:
  std::unique_ptr<CalibrationStore> Make() const {
    auto opened = OpenSqliteStore(file_, {.create = true});
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
    return opened ? std::move(*opened) : nullptr;
  }
  /// A store with a revision in force, closed again.
  void MakeWithRevision() const {
    const auto store = Make();
    ASSERT_TRUE(store->Append(ExampleRevision("studio", 1)));
    ASSERT_TRUE(store->Publish(ExampleRequest("studio", 1, {})));
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.Path() / kStoreFile;
};

/// What schema 1 was, with two rigs; the second one's pointer had moved.
constexpr const char* kOldStore = R"(
PRAGMA application_id = 1919378284;
PRAGMA user_version = 1;
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

void WriteOldStore(const std::filesystem::path& file) {
  SQLite::Database old(file.string(), kOpenForWriting);
  old.exec(kOldStore);
  for (const int variant : {1, 2, 3}) {
    const CalibrationRevision revision = ExampleRevision(variant == 1 ? "left" : "right", variant);
    SQLite::Statement insert(
        old,
        "INSERT INTO revision(rig, time, verdict, reasons, parent, recording_id, recording_sha256, provenance, "
        "calibration, report) VALUES(?, ?, 'accepted', '[]', ?, 'night', '', ?, ?, ?)");
    insert.bind(1, revision.head.rig);
    insert.bind(2, revision.head.time);
    if (variant == 3) insert.bind(3, 2);
    insert.bind(4, R"({"program": "rigcal", "version": "0.0.9", "method": "rigcal", "options": {"rounds": "4"},)"
                   R"( "random_seed": 7, "inputs": [], "notes": []})");
    insert.bind(5, revision.calibration_text);
    insert.bind(6, revision.report_text);
    insert.exec();
  }
  old.exec("INSERT INTO in_force VALUES('right', 3, '2025-12-01T00:00:00Z', 'otto')");
}

TEST_F(SqliteStoreFile, OldSchemaIsUpgradedAndUpgradedOnlyOnce) {
  WriteOldStore(file_);
  std::string after_first;
  for (const int time : {1, 2}) {
    const auto opened = OpenSqliteStore(file_);
    ASSERT_TRUE(opened) << opened.error().message;
    CalibrationStore& store = **opened;
    EXPECT_THAT(*store.Rigs(), ElementsAre("left", "right"));
    for (const int number : {1, 2, 3}) {
      const std::string rig = number == 1 ? "left" : "right";
      const auto revision = store.Load(rig, number);
      ASSERT_TRUE(revision) << revision.error().message;
      EXPECT_EQ(revision->calibration_text, ExampleRevision(rig, number).calibration_text);
      EXPECT_EQ(revision->head.origin.run.program_version, "0.0.9");
      EXPECT_EQ(revision->head.calibration_sha256, Sha256Hex(revision->calibration_text));
    }
    EXPECT_EQ(store.Load("right", 3)->head.parent, 2);
    EXPECT_FALSE(*store.InForce("left"));
    const auto events = store.History("right")->events;
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].revision, 3);
    EXPECT_EQ(events[0].by, "otto");
    EXPECT_EQ(events[0].time, "2025-12-01T00:00:00Z");
    EXPECT_THAT(events[0].reason, HasSubstr("schema 2"));
    EXPECT_THAT(*store.Check({}), IsEmpty()) << "time " << time;  // the schema is that of a new store, too
    const auto dump = folder_.Path() / fmt::format("dump{}", time);
    ASSERT_TRUE(store.Backup(dump));
    if (time == 1) after_first = *ReadFile(dump);
    EXPECT_EQ(*ReadFile(dump), after_first);
  }
  const auto store = Make();
  ASSERT_TRUE(store->Append(ExampleRevision("left", 9)));
  EXPECT_TRUE(store->Publish(ExampleRequest("right", 2, 3)));
}

TEST_F(SqliteStoreFile, FailedUpgradeChangesNothing) {
  WriteOldStore(file_);
  // A pointer that no event can be made of: its time is none.
  SQLite::Database(file_.string(), SQLite::OPEN_READWRITE).exec("UPDATE in_force SET time = 'then'");
  const std::string bytes = *ReadFile(file_);
  EXPECT_FALSE(OpenSqliteStore(file_));
  EXPECT_EQ(*ReadFile(file_), bytes);
}

TEST_F(SqliteStoreFile, NewerSchemaIsRefused) {
  Make();
  SQLite::Database(file_.string(), SQLite::OPEN_READWRITE).exec("PRAGMA user_version = 3");
  const auto opened = OpenSqliteStore(file_);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message, HasSubstr("has schema 3, this program knows up to 2"));
}

TEST_F(SqliteStoreFile, OtherFilesAreRefusedAndKept) {
  const auto missing = OpenSqliteStore(file_);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(std::filesystem::exists(file_));
  const auto text = folder_.Write("text", std::string(5000, 'x'));
  const auto no_database = OpenSqliteStore(text, {.create = true});
  ASSERT_FALSE(no_database);
  EXPECT_THAT(no_database.error().message, HasSubstr("is no SQLite database"));
  const auto foreign = folder_.Path() / "foreign";
  SQLite::Database(foreign.string(), kOpenForWriting).exec("CREATE TABLE theirs(x)");
  const std::string bytes = *ReadFile(foreign);
  const auto no_store = OpenSqliteStore(foreign, {.create = true});
  ASSERT_FALSE(no_store);
  EXPECT_THAT(no_store.error().message, HasSubstr("no calibration store"));
  EXPECT_EQ(*ReadFile(foreign), bytes);
  EXPECT_FALSE(OpenSqliteStore(folder_.Path()));
}

TEST_F(SqliteStoreFile, NoSqlChangesWhatWasStored) {
  MakeWithRevision();
  SQLite::Database foreign(file_.string(), SQLite::OPEN_READWRITE);
  for (const std::string sql :
       {"UPDATE revision SET verdict = 'rejected'", "DELETE FROM revision", "UPDATE publish_event SET person = 'otto'",
        "DELETE FROM publish_event", "INSERT OR REPLACE INTO revision SELECT * FROM revision",
        "INSERT OR REPLACE INTO publish_event SELECT * FROM publish_event", "UPDATE OR REPLACE revision SET number = 2",
        "INSERT INTO publish_event(rig, time, kind, revision, previous, person, reason) "
        "VALUES('studio', '2026-01-01T00:00:00Z', 'publish', 1, NULL, 'otto', '')"}) {
    EXPECT_THROW(foreign.exec(sql), SQLite::Exception) << sql;
  }
  const auto store = Make();
  ExpectSame(*store->Load("studio", 1), ExampleRevision("studio", 1));
  EXPECT_THAT(*store->Check({}), IsEmpty());
}

TEST_F(SqliteStoreFile, DamageIsFound) {
  MakeWithRevision();
  SQLite::Database foreign(file_.string(), SQLite::OPEN_READWRITE);
  foreign.exec("DROP TRIGGER revision_is_not_changed");
  const auto store = Make();
  EXPECT_THAT(*store->Check({}), ElementsAre(HasSubstr("trigger revision_is_not_changed is missing")));
  foreign.exec("UPDATE revision SET calibration = replace(calibration, '64', '65')");
  const auto loaded = store->Load("studio", 1);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kIo);
  EXPECT_THAT(loaded.error().message, HasSubstr("the calibration of revision 1 is damaged"));
  EXPECT_THAT(*store->Check({}), ElementsAre(HasSubstr("trigger"), HasSubstr("revision 1")));
  foreign.exec("UPDATE revision SET reasons = '[1]'");
  const auto history = store->History("studio");
  ASSERT_FALSE(history);
  EXPECT_THAT(history.error().message, HasSubstr("a row is damaged"));
}

TEST_F(SqliteStoreFile, AnotherThatHoldsItIsATimeout) {
  MakeWithRevision();
  SQLite::Database foreign(file_.string(), SQLite::OPEN_READWRITE);
  const SQLite::Transaction held(foreign, SQLite::TransactionBehavior::IMMEDIATE);
  const auto opened = OpenSqliteStore(file_, {.busy_timeout_ms = 20});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_TRUE((*opened)->Load("studio", 1)) << "who reads does not wait";
  const auto appended = (*opened)->Append(ExampleRevision("studio", 2));
  ASSERT_FALSE(appended);
  EXPECT_EQ(appended.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(appended.error().message, HasSubstr("another program holds the store"));
}

/// Runs `work` in a child, which may give up rights or reach limits, and returns what it says.
template <typename Work>
std::string InChild(const Work& work) {
  std::array<int, 2> ends{};
  EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
  const pid_t child = fork();
  if (child == 0) {
    const std::string said = work();
    _exit(write(ends[1], said.data(), said.size()) == static_cast<ssize_t>(said.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string said(4096, '\0');
  const ssize_t size = read(ends[0], said.data(), said.size());
  close(ends[0]);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  said.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
  return said;
}

template <typename T>
std::string SaidBy(const Result<T>& result) {
  return result ? "no error" : fmt::format("{} {}", static_cast<int>(result.error().code), result.error().message);
}

std::string Code(ErrorCode code) {
  return fmt::format("{} ", static_cast<int>(code));
}

/// Root may write everywhere.
void GiveUpRoot() {
  constexpr uid_t kNobody = 65534;
  if (geteuid() == 0 && setuid(kNobody) != 0) _exit(2);
}

TEST_F(SqliteStoreFile, ReadOnlyStateFolderIsNamed) {
  MakeWithRevision();
  ASSERT_EQ(chmod(file_.c_str(), 0444), 0);
  ASSERT_EQ(chmod(folder_.Path().c_str(), 0555), 0);
  const auto opened_without_rights = [this](bool create, const std::filesystem::path& file) {
    return InChild([&] {
      GiveUpRoot();
      return SaidBy(OpenSqliteStore(file, {.create = create}));
    });
  };
  const auto named_as_unwritable =
      ::testing::AllOf(::testing::StartsWith(Code(ErrorCode::kIo)), HasSubstr(folder_.Path().string()));
  EXPECT_THAT(opened_without_rights(false, file_), named_as_unwritable);
  EXPECT_THAT(opened_without_rights(true, folder_.Path() / "new" / kStoreFile), named_as_unwritable);
  ASSERT_EQ(chmod(file_.c_str(), 0666), 0);
  EXPECT_THAT(opened_without_rights(false, file_), named_as_unwritable);
  ASSERT_EQ(chmod(folder_.Path().c_str(), 0), 0);
  EXPECT_THAT(opened_without_rights(false, file_), named_as_unwritable) << "it is not missing, it cannot be seen";
  ASSERT_EQ(chmod(folder_.Path().c_str(), 0755), 0);
}

/// A file limit is a full disk that needs no root.
TEST_F(SqliteStoreFile, FullDiskIsSaidAndNothingIsHalfStored) {
  MakeWithRevision();
  const std::string said = InChild([this]() -> std::string {
    signal(SIGXFSZ, SIG_IGN);
    auto store = OpenSqliteStore(file_);
    if (!store) return SaidBy(store);
    constexpr rlim_t kLimit = 300'000;
    const rlimit limit{kLimit, kLimit};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return "no limit";
    for (int variant = 2; variant < 1000; ++variant) {
      const auto number = (*store)->Append(ExampleRevision("studio", variant));
      if (!number) return SaidBy(number);
    }
    return "never full";
  });
  EXPECT_THAT(said, ::testing::StartsWith(Code(ErrorCode::kDiskFull)));
  EXPECT_THAT(said, HasSubstr("no space left"));
  const auto store = Make();
  EXPECT_THAT(*store->Check({}), IsEmpty());
  EXPECT_EQ((*store->InForce("studio"))->revision, 1);
  EXPECT_TRUE(store->Append(ExampleRevision("studio", 1000))) << "with space it goes on";
}

TEST_F(SqliteStoreFile, FullFileSystemIsSaid) {
  if (mount("none", folder_.Path().c_str(), "tmpfs", 0, "size=256k") != 0) {
    GTEST_SKIP() << "mounting a tiny tmpfs needs root";
  }
  {
    const auto store = Make();
    Result<int> appended = 0;
    for (int variant = 1; appended && variant < 1000; ++variant) {
      appended = store->Append(ExampleRevision("studio", variant));
    }
    EXPECT_THAT(SaidBy(appended), ::testing::StartsWith(Code(ErrorCode::kDiskFull)));
    const auto backup = store->Backup(folder_.Path() / "backup");
    EXPECT_THAT(SaidBy(backup), ::testing::StartsWith(Code(ErrorCode::kDiskFull)));
    EXPECT_FALSE(std::filesystem::exists(folder_.Path() / "backup"));
  }
  EXPECT_THAT(*Make()->Check({}), IsEmpty());
  umount(folder_.Path().c_str());
}

}  // namespace
}  // namespace rigcal
