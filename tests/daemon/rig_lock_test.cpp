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

TEST(RigLock, AFolderThatCannotBeIsAnError) {
  TemporaryFolder folder;
  const auto rig = folder.Write("rig.toml", "");
  const Result<RigLock> lock = RigLock::Take(rig / "run", rig, kCapture);
  ASSERT_FALSE(lock);
  EXPECT_EQ(lock.error().code, ErrorCode::kIo);
}

}  // namespace
}  // namespace rigcal
