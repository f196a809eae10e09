#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include "config/json_content.h"
#include "config/publish_files.h"
#include "config/read_file.h"
#include "config/store/sqlite_store.h"
#include "core/base/random.h"
#include "tests/config/example_revision.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

constexpr const char* kRig = "studio";

/// What stores and publishes until it is killed; a byte through the pipe for each publish that begins.
[[noreturn]] void PublishForEver(const std::filesystem::path& file, const PublishFolder& target, int pipe_end) {
  SystemClock clock;
  auto store = OpenSqliteStore(file);
  if (!store) _exit(1);
  for (;;) {
    const auto last = (*store)->InForce(kRig);
    if (!last) _exit(2);
    const std::optional<int> expected = *last ? std::optional((*last)->revision) : std::nullopt;
    const auto number = (*store)->Append(ExampleRevision(kRig, expected.value_or(0) + 1));
    if (!number || write(pipe_end, "p", 1) != 1) _exit(3);
    if (!PublishRevision(**store, ExampleRequest(kRig, *number, expected), target, clock, {})) _exit(4);
  }
}

/// The child, from its start to its violent end.
class Victim {
 public:
  Victim(const std::filesystem::path& file, const PublishFolder& target) {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe(ends.data()), 0);
    process_ = fork();
    if (process_ == 0) PublishForEver(file, target, ends[1]);
    close(ends[1]);
    begun_ = ends[0];
  }
  Victim(const Victim&) = delete;
  Victim& operator=(const Victim&) = delete;
  ~Victim() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    close(begun_);
  }

  /// Until the child begins its next publish.
  void AwaitPublish() const {
    constexpr int kHangMs = 60'000;
    pollfd waiting{begun_, POLLIN, 0};
    char byte = 0;
    ASSERT_EQ(poll(&waiting, 1, kHangMs), 1);
    ASSERT_EQ(read(begun_, &byte, 1), 1) << "the child ended by itself";
  }

  void Kill() const { ASSERT_EQ(kill(process_, SIGKILL), 0); }

 private:
  pid_t process_ = -1;
  int begun_ = -1;
};

/// current.json is whole: that of an event that was, the last one or the one before the crash.
void ExpectWholeCurrent(CalibrationStore& store, const PublishFolder& target) {
  const auto text = ReadFile(target.folder / kCurrentFile);
  if (!text) return;  // nothing was shown yet
  const auto json = nlohmann::ordered_json::parse(*text, nullptr, false);
  ASSERT_TRUE(json.is_object()) << "current.json is torn";
  const int number = json["revision"]["number"];
  const auto events = store.History(kRig)->events;
  const auto event = std::ranges::find(events, number, &PublishEvent::revision);
  ASSERT_NE(event, events.end()) << "current.json shows revision " << number << ", which never was in force";
  EXPECT_EQ(*text, *CurrentText(*store.Load(kRig, number), *event, target.formats));
}

/// In memory where there is such a folder: what a killed process has written is there without a sync, and 200 kills
/// take seconds. A power cut is not what is tried here.
std::filesystem::path QuickFolder() {
  const std::filesystem::path in_memory = "/dev/shm";
  return access(in_memory.c_str(), W_OK) == 0 ? in_memory : std::filesystem::temp_directory_path();
}

TEST(Crash, KilledAtAnyMomentOfPublishingAWholeRevisionIsInForce) {
  constexpr int kKills = 200;
  using Seconds = std::chrono::duration<double>;
  const TemporaryFolder folder(QuickFolder());
  const std::filesystem::path file = folder.Path() / kStoreFile;
  const PublishFolder target{folder.Path() / "published", {{"middlebury"}, {"colmap"}}};
  SystemClock clock;
  ASSERT_TRUE(OpenSqliteStore(file, {.create = true}));
  Random random(20261122);
  int published = 0, mended = 0;
  for (int k = 0; k < kKills; ++k) {
    {
      const Victim victim(file, target);
      victim.AwaitPublish();
      const double begin_s = clock.NowS();
      victim.AwaitPublish();
      // Anywhere in the next one, however fast the machine is.
      std::this_thread::sleep_for(Seconds(random.Uniform() * (clock.NowS() - begin_s)));
      victim.Kill();
    }
    const auto opened = OpenSqliteStore(file);
    ASSERT_TRUE(opened) << "kill " << k << ": " << opened.error().message;
    CalibrationStore& store = **opened;
    const auto event = store.InForce(kRig);
    ASSERT_TRUE(event);
    ExpectWholeCurrent(store, target);
    if (!*event) continue;
    const auto revision = store.Load(kRig, (*event)->revision);
    ASSERT_TRUE(revision) << "kill " << k << ": " << revision.error().message;
    EXPECT_TRUE(CheckRevision(*revision));
    const auto repaired = RepairPublished(store, kRig, target, clock, {});
    ASSERT_TRUE(repaired) << repaired.error().message;
    mended += *repaired;
    published = (*event)->number;
    EXPECT_EQ(*ReadFile(target.folder / kCurrentFile), *CurrentText(*revision, **event, target.formats));
    if (HasFailure()) return;
  }
  const auto store = OpenSqliteStore(file);
  EXPECT_THAT(*(*store)->Check({}), ::testing::IsEmpty());
  // Moments before, in and after a publish were hit; otherwise this test has shown nothing.
  EXPECT_GT(published, kKills / 2);
  EXPECT_GT(mended, 0);
  fmt::print("{} kills, {} publishes, {} mended\n", kKills, published, mended);
}

}  // namespace
}  // namespace rigcal
