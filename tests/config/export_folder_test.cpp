#include "config/export_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/read_file.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const ExportedFiles kOld = {{"cameras.txt", "old"}, {"txt/1.txt", "one"}, {"gone.txt", ""}};
const ExportedFiles kNew = {{"cameras.txt", "new"}, {"txt/2.txt", "two"}};

/// All files below a folder with their content.
std::map<std::string, std::string> FilesIn(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder).string()] = *ReadFile(entry.path());
  return files;
}

TEST(ExportFolder, TakesItsPlaceAsAWhole) {
  const TemporaryFolder folder;
  const auto out = folder.Path() / "made" / "out";
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, out)), kNoError);
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kNew, out / "")), kNoError);  // "out/" is "out"
  auto files = FilesIn(out);
  files.erase(kExportListFile);
  EXPECT_EQ(files, kNew);  // nothing of the old one is left
  EXPECT_EQ(FilesIn(folder.Path() / "made").size(), kNew.size() + 1);
  const auto readable_by_all = std::filesystem::perms::others_read | std::filesystem::perms::others_exec;
  EXPECT_EQ(std::filesystem::status(out).permissions() & readable_by_all, readable_by_all);
}

TEST(ExportFolder, FollowsALink) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.Path() / "real");
  std::filesystem::create_directory_symlink(folder.Path() / "real", folder.Path() / "link");
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, folder.Path() / "link")), kNoError);
  EXPECT_TRUE(std::filesystem::is_symlink(folder.Path() / "link"));
  EXPECT_EQ(*ReadFile(folder.Path() / "real" / "cameras.txt"), "old");
}

class KeptFolder : public ::testing::Test {
 protected:
  /// Refuses to replace the folder, which stays as it is.
  void ExpectKept(const std::string& format, const std::string& word) {
    const auto before = FilesIn(folder_.Path());
    const auto refused = ReplaceExportFolder(format, kNew, Out());
    ASSERT_FALSE(refused) << word;
    EXPECT_EQ(refused.error().code, ErrorCode::kBadInput);
    EXPECT_THAT(refused.error().message, AllOf(HasSubstr(Out().string()), HasSubstr(word)));
    EXPECT_EQ(FilesIn(folder_.Path()), before);
  }
  [[nodiscard]] std::filesystem::path Out() const { return folder_.Path() / "out"; }
  TemporaryFolder folder_;
};

TEST_F(KeptFolder, OfAnotherFormat) {
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, Out())), kNoError);
  ExpectKept("pmvs", "pmvs");
}

TEST_F(KeptFolder, WithAFileThatSomebodyAdded) {
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, Out())), kNoError);
  folder_.Write("out/visualize/mine.jpg", "a picture");
  ExpectKept("colmap", "mine.jpg");
}

TEST_F(KeptFolder, WithAFileThatSomebodyChanged) {
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, Out())), kNoError);
  folder_.Write("out/txt/1.txt", "edited");
  ExpectKept("colmap", "txt/1.txt");
}

TEST_F(KeptFolder, WithALinkInIt) {
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, Out())), kNoError);
  std::filesystem::create_directory_symlink(folder_.Path(), Out() / "pictures");
  ExpectKept("colmap", "pictures");
}

TEST_F(KeptFolder, OfSomebodyElse) {
  folder_.Write("out/cameras.txt", "# mine");
  ExpectKept("colmap", "is no export");
  folder_.Write("out/" + std::string(kExportListFile), "no JSON");
  ExpectKept("colmap", "is no export");
  folder_.Write("out/" + std::string(kExportListFile), R"({"format": "colmap", "files": []})");
  ExpectKept("colmap", "is no export");
}

TEST_F(KeptFolder, AFileInItsPlace) {
  folder_.Write("out", "mine");
  ExpectKept("colmap", "a folder is needed");
}

TEST_F(KeptFolder, WhenTheNewOneCannotBeWritten) {
  ASSERT_EQ(Message(ReplaceExportFolder("colmap", kOld, Out())), kNoError);
  const auto before = FilesIn(folder_.Path());
  ExportedFiles files = kNew;
  files["z" + std::string(300, 'x')] = "no file system takes this name";
  const auto failed = ReplaceExportFolder("colmap", files, Out());
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kIo);
  EXPECT_EQ(FilesIn(folder_.Path()), before);  // the old one whole, nothing half-written beside it
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.Path()), {}), 1);
}

}  // namespace
}  // namespace rigcal
