#include "daemon/rig_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>

#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const RigHolder kService = {.what = "rigcald", .ask_instead = "rigcal job capture"};
const RigHolder kCapture = {.what = "rigcal capture --out night7", .ask_instead = ""};

TEST(RigLock, OneHoldsARigAndTheOthersAreToldWho) {
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", "");
  std::optional<Result<RigLock>> first(RigLock::Take(folder.Path() / "run", rig, kService));
  ASSERT_TRUE(*first) << first->error().message;
  const Result<RigLock> second = RigLock::Take(folder.Path() / "run", rig, kCapture);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kDevice);
  EXPECT_THAT(second.error().message, AllOf(HasSubstr(fmt::format("process {} (rigcald)", getpid())),
                                            HasSubstr("rigcal job capture"), HasSubstr("rig.toml")));
  first.reset();
  EXPECT_TRUE(RigLock::Take(folder.Path() / "run", rig, kCapture));
}

TEST(RigLock, TwoRigsAreTwoLocksAndAPathIsOneHoweverItIsWritten) {
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", ""), other = folder.Write("other.toml", "");
  const Result<RigLock> first = RigLock::Take(folder.Path() / "run", rig, kCapture);
  ASSERT_TRUE(first);
  EXPECT_TRUE(RigLock::Take(folder.Path() / "run", other, kCapture));
  EXPECT_FALSE(RigLock::Take(folder.Path() / "run", folder.Path() / "run" / ".." / "rig.toml", kCapture));
}

TEST(RigLock, IsFreeAgainWhenItsHolderWasKilled) {
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", "");
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const Result<RigLock> lock = RigLock::Take(folder.Path() / "run", rig, kService);
    if (!lock) _exit(1);
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_TRUE(RigLock::Take(folder.Path() / "run", rig, kCapture));
}

/// Without the rights of root, as long as it lives.
class AsNobody {
 public:
  AsNobody() : before_(geteuid()) {
    if (before_ == 0) {
      EXPECT_EQ(seteuid(kNobody), 0);
    }
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;
  ~AsNobody() { EXPECT_EQ(seteuid(before_), 0); }

 private:
  static constexpr uid_t kNobody = 65534;
  uid_t before_;
};

TEST(RigLock, WhoMayNotWriteTheFileOfAnotherUserIsToldWhoHoldsTheRig) {
  namespace fs = std::filesystem;
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", ""), run = folder.Path() / "run";
  std::optional<Result<RigLock>> service(RigLock::Take(run, rig, kService));
  ASSERT_TRUE(*service);
  constexpr auto kAllMayLook =
      fs::perms::group_read | fs::perms::group_exec | fs::perms::others_read | fs::perms::others_exec;
  for (const fs::path& shared : {folder.Path(), run}) {
    fs::permissions(shared, kAllMayLook, fs::perm_options::add);
  }
  fs::permissions(fs::directory_iterator(run)->path(),
                  fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read);
  const AsNobody nobody;
  const Result<RigLock> held = RigLock::Take(run, rig, kCapture);
  ASSERT_FALSE(held);
  EXPECT_EQ(held.error().code, ErrorCode::kDevice) << held.error().message;
  EXPECT_THAT(held.error().message, HasSubstr("rigcal job capture"));
  service.reset();
  const Result<RigLock> free = RigLock::Take(run, rig, kCapture);
  ASSERT_FALSE(free) << "others could not be told who holds it";
  EXPECT_EQ(free.error().code, ErrorCode::kIo);
}

TEST(RigLock, ALinkInItsPlaceIsNotFollowed) {
  namespace fs = std::filesystem;
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", ""), mine = folder.Write("mine", "kept"), run = folder.Path() / "run";
  ASSERT_TRUE(RigLock::Take(run, rig, kCapture));
  const fs::path lock = fs::directory_iterator(run)->path();
  fs::remove(lock);
  fs::create_symlink(mine, lock);
  const Result<RigLock> taken = RigLock::Take(run, rig, kCapture);
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, ErrorCode::kIo);
  EXPECT_EQ(fs::file_size(mine), 4u);
}

TEST(RigLock, AFolderThatCannotBeIsAnError) {
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", "");
  const Result<RigLock> lock = RigLock::Take(rig / "run", rig, kCapture);
  ASSERT_FALSE(lock);
  EXPECT_EQ(lock.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace rigcal
