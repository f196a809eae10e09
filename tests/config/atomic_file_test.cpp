#include "config/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include "config/read_file.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

std::ptrdiff_t NumFiles(const std::filesystem::path& folder) {
  return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}

TEST(AtomicFile, ReplacesAWholeFile) {
  const TemporaryFolder folder;
  const auto path = folder.Write("out.json", "before, and longer");
  ASSERT_TRUE(WriteFileAtomically(path, "after"));
  EXPECT_EQ(*ReadFile(path), "after");
  EXPECT_EQ(NumFiles(folder.Path()), 1);
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0644U);
}

TEST(AtomicFile, MissingFolderIsNamed) {
  const TemporaryFolder folder;
  const auto written = WriteFileAtomically(folder.Path() / "missing" / "out.json", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_THAT(written.error().message, HasSubstr("missing/out.json"));
}

TEST(AtomicFile, FailedRenameLeavesNothingBehind) {
  const TemporaryFolder folder;
  folder.Write("out.json/inside", "a folder stands where the file should go");
  const auto written = WriteFileAtomically(folder.Path() / "out.json", "text");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kIo);
  EXPECT_EQ(NumFiles(folder.Path()), 1);
}

TEST(AtomicFile, OutputFolderIsMadeAndTried) {
  const TemporaryFolder folder;
  ASSERT_TRUE(PrepareOutputFolder(folder.Path() / "a" / "b"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path() / "a" / "b"));
  const auto file = folder.Write("file", "");
  const auto on_file = PrepareOutputFolder(file);
  ASSERT_FALSE(on_file);
  EXPECT_THAT(on_file.error().message, HasSubstr(file.string()));
  EXPECT_FALSE(PrepareOutputFolder(file / "below"));
  // Root may write everywhere, except where there is no file system to write to.
  EXPECT_FALSE(PrepareOutputFolder("/proc/rigcal"));
}

/// A file system of 64 kB, gone at the end of the test.
class TinyDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    mounted_ = mount("none", folder_.Path().c_str(), "tmpfs", 0, "size=64k") == 0;
    if (!mounted_) GTEST_SKIP() << "mounting a tiny tmpfs needs root";
  }
  void TearDown() override {
    if (mounted_) umount(folder_.Path().c_str());
  }
  TemporaryFolder folder_;
  bool mounted_ = false;
};

TEST_F(TinyDisk, FullDiskIsSaidAndTheOldFileStays) {
  const auto path = folder_.Write("out.json", "before");
  const auto written = WriteFileAtomically(path, std::string(1 << 20, 'x'));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kDiskFull);
  EXPECT_THAT(written.error().message, HasSubstr("no space left"));
  EXPECT_EQ(*ReadFile(path), "before");
  EXPECT_EQ(NumFiles(folder_.Path()), 1);
}

TEST(ReadFile, HashesAsOthersDo) {
  EXPECT_EQ(Sha256Hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const TemporaryFolder folder;
  EXPECT_EQ(*ReadFile(folder.Write("empty", "")), "");
  EXPECT_FALSE(ReadFile(folder.Path()));
}

TEST(AtomicFile, KnowsWhatAKilledProgramLeaves) {
  for (const char* left : {".recording.json.Ab3dE6", ".left_00.png.000000", ".a.b.c.zzzzzz", ".probe.Ab3dE6"}) {
    EXPECT_TRUE(IsTemporaryName(left)) << left;
  }
  for (const char* other :
       {"recording.json", ".recording.json", "recording.json.Ab3dE6", ".recording.json.Ab3dE", "",
        ".recording.json.Ab3dE67", ".recording.json.Ab-dE6", ".config.backup", "..a.Ab3dE6", ".Ab3dE6", ".a..Ab3dE6"}) {
    EXPECT_FALSE(IsTemporaryName(other)) << other;
  }
}

}  // namespace
}  // namespace rigcal
