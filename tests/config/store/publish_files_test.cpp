#include "config/publish_files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <set>

#include "config/formats/format_table.h"
#include "config/json_content.h"
#include "config/load_cameras.h"
#include "config/read_file.h"
#include "config/staged_files.h"
#include "config/store/sqlite_store.h"
#include "tests/config/example_revision.h"
#include "tests/config/schema_check.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

/// Time passes only by waiting.
class HeldClock final : public Clock {
 public:
  [[nodiscard]] double NowS() const override { return now_s_; }
  bool Wait(double seconds, const std::stop_token& stop) override {
    now_s_ += seconds;
    return !stop.stop_requested();
  }

 private:
  double now_s_ = 0;
};

mode_t ModeOf(const std::filesystem::path& path) {
  struct stat status {};
  EXPECT_EQ(stat(path.c_str(), &status), 0) << path;
  return status.st_mode & 0777;
}

class PublishFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    store_ = std::move(*OpenSqliteStore(folder_.Path() / kStoreFile, {.create = true}));
    for (const int variant : {1, 2}) ASSERT_TRUE(store_->Append(ExampleRevision("studio", variant)));
  }

  Result<Published> Publish(int revision, std::optional<int> expected) {
    return PublishRevision(*store_, ExampleRequest("studio", revision, expected), target_, clock_, {});
  }
  Result<bool> Repair() { return RepairPublished(*store_, "studio", target_, clock_, {}); }
  std::string Current() const { return ReadFile(target_.folder / kCurrentFile).value_or("not there"); }
  std::string Expected() {
    const PublishEvent event = **store_->InForce("studio");
    return *CurrentText(*store_->Load("studio", event.revision), event, target_.formats);
  }
  /// fx of what a published file or folder holds, told apart between the variants.
  double FocalPx(const std::string& name) const {
    const auto loaded = LoadCamerasUnchanged(target_.folder / name);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().message);
    return loaded ? loaded->calibration.cameras[0].fx_px : 0;
  }
  static double FocalOf(int variant) {
    return ParseCalibration(ExampleRevision("studio", variant).calibration_text, "")->calibration.cameras[0].fx_px;
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(target_.folder)) {
      const std::string name = entry.path().filename();
      names.push_back(name.starts_with(".files-") ? ".files" : name);
    }
    std::ranges::sort(names);
    return names;
  }

  TemporaryFolder folder_;
  std::unique_ptr<CalibrationStore> store_;
  PublishFolder target_{folder_.Path() / "published", {{"middlebury"}, {"colmap"}, {"opencv"}}};
  HeldClock clock_;
};

TEST_F(PublishFiles, EveryFormatShowsTheRevisionInForceToEverybody) {
  const mode_t before = umask(077);
  const auto first = Publish(1, {});
  umask(before);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_THAT(Names(), ::testing::ElementsAre(".files", "cameras_par.txt", "colmap", "current.json", "opencv.yml"));
  EXPECT_EQ(Current(), Expected());
  for (const char* name : {"current.json", "cameras_par.txt", "colmap"}) EXPECT_DOUBLE_EQ(FocalPx(name), FocalOf(1));
  for (const char* name : {"current.json", "cameras_par.txt", "opencv.yml", "colmap/cameras.txt"}) {
    EXPECT_EQ(ModeOf(target_.folder / name), 0644U) << name;
  }
  for (const char* name : {"", "colmap"}) EXPECT_EQ(ModeOf(target_.folder / name), 0755U) << name;

  const auto old_colmap = std::filesystem::canonical(target_.folder / "colmap");
  ASSERT_TRUE(Publish(2, 1));
  for (const char* name : {"current.json", "cameras_par.txt", "colmap"}) EXPECT_DOUBLE_EQ(FocalPx(name), FocalOf(2));
  EXPECT_TRUE(std::filesystem::exists(old_colmap / "images.txt")) << "somebody may be reading it";
  PublishRequest back = ExampleRequest("studio", 1, 2);
  back.kind = PublishKind::kRollback;
  ASSERT_TRUE(PublishRevision(*store_, back, target_, clock_, {}));
  EXPECT_DOUBLE_EQ(FocalPx("colmap"), FocalOf(1));
  EXPECT_FALSE(std::filesystem::exists(old_colmap));
}

TEST_F(PublishFiles, CurrentJsonIsTheCalibrationAndItsNumber) {
  CalibrationRevision revision = ExampleRevision("studio", 1, Verdict::kRejected);
  revision.head.number = 7;
  const PublishEvent event{
      .rig = "studio", .time = "2026-02-01T06:00:00Z", .revision = 7, .by = "anna", .reason = "by hand"};
  const auto text = CurrentText(revision, event, target_.formats);
  ASSERT_TRUE(text);
  EXPECT_EQ(SchemaComplaints("calibration.schema.json", *text), "");
  auto json = nlohmann::ordered_json::parse(*text);
  EXPECT_EQ(json["revision"]["number"], 7);
  EXPECT_EQ(json["revision"]["rig"], "studio");
  EXPECT_EQ(json["revision"]["verdict"], "rejected");
  EXPECT_EQ(json["revision"]["published_by"], "anna");
  EXPECT_EQ(json["revision"]["reason"], "by hand");
  EXPECT_EQ(json["revision"]["files"][1]["name"], "colmap");
  json.erase("revision");
  EXPECT_EQ(json, nlohmann::ordered_json::parse(revision.calibration_text));
}

TEST_F(PublishFiles, WhatAFormatCannotHoldMovesNothing) {
  RigCalibration bent = ExampleRing(3);
  bent.cameras[0].k1 = 0.1;
  CalibrationRevision revision = ExampleRevision("studio", 3);
  revision.calibration_text = CalibrationText(bent, revision.head.origin.run);
  ASSERT_TRUE(Publish(1, {}));
  const int number = *store_->Append(revision);
  const std::string before = Current();
  const auto refused = Publish(number, 1);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("distortion"));
  EXPECT_EQ((*store_->InForce("studio"))->revision, 1);
  EXPECT_EQ(Current(), before);
  EXPECT_THAT(Names(), ::testing::ElementsAre(".files", "cameras_par.txt", "colmap", "current.json", "opencv.yml"));
  target_.formats = {{"middlebury", true}};
  const auto published = Publish(number, 1);
  ASSERT_TRUE(published) << published.error().message;
  EXPECT_THAT(published->notes, ::testing::ElementsAre(HasSubstr("cameras_par.txt: these cameras fit undistorted")));
  target_.formats = {{"sketch"}};
  EXPECT_FALSE(Publish(2, number));
}

TEST_F(PublishFiles, FolderThatCannotBeWrittenMovesNothing) {
  target_.folder = folder_.Write("file", "");
  const auto refused = Publish(1, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr(target_.folder.string()));
  EXPECT_FALSE(*store_->InForce("studio"));
}

TEST_F(PublishFiles, RepairWritesWhatACrashLeftOut) {
  EXPECT_FALSE(*Repair()) << "nothing is in force";
  ASSERT_TRUE(store_->Publish(ExampleRequest("studio", 1, {})));  // and then the light went out
  const auto repaired = Repair();
  ASSERT_TRUE(repaired) << repaired.error().message;
  EXPECT_TRUE(*repaired);
  EXPECT_EQ(Current(), Expected());
  EXPECT_DOUBLE_EQ(FocalPx("colmap"), FocalOf(1));
  EXPECT_FALSE(*Repair()) << "it is right already";
  for (const char* name : {"colmap", "cameras_par.txt", "current.json"}) {
    std::filesystem::remove(target_.folder / name);
    EXPECT_TRUE(*Repair()) << name;
    EXPECT_DOUBLE_EQ(FocalPx(name), FocalOf(1));
  }
  target_.formats.pop_back();
  target_.formats[0].undistorted = true;
  EXPECT_TRUE(*Repair()) << "the rig file asks for something else";
}

TEST_F(PublishFiles, EachFormatHasANameOfItsOwn) {
  std::set<std::string> names;
  for (const FormatEntry& entry : ExportFormats()) {
    EXPECT_TRUE(names.insert(PublishedName(std::string(entry.name))).second) << entry.name;
  }
  EXPECT_TRUE(names.contains("cameras_par.txt") && names.contains("opencv.yml") && names.contains("colmap-bin"));
  EXPECT_FALSE(names.contains(kCurrentFile));
}

TEST_F(PublishFiles, FormatsNoLongerWantedDoNotGrowOld) {
  ASSERT_TRUE(Publish(1, {}));
  folder_.Write("published/theirs.txt", "kept");
  target_.formats = {{"opencv"}};
  ASSERT_TRUE(Publish(2, 1));
  EXPECT_THAT(Names(), ::testing::ElementsAre("current.json", "opencv.yml", "theirs.txt"));
}

TEST_F(PublishFiles, LeftoversOfACrashGo) {
  std::filesystem::create_directories(target_.folder / ".files-abcdef" / "colmap");
  folder_.Write("published/.current.json.abcdef", "torn");
  folder_.Write("published/.probe.abcdef", "");
  folder_.Write("published/theirs.txt", "kept");
  ASSERT_TRUE(Publish(1, {}));
  EXPECT_THAT(Names(), ::testing::ElementsAre(".files", "cameras_par.txt", "colmap", "current.json", "opencv.yml",
                                              "theirs.txt"));
}

TEST_F(PublishFiles, SomethingElseInItsPlaceIsKeptAndMovesNothing) {
  for (const char* theirs : {"colmap/theirs.txt", "opencv.yml/theirs.txt", "colmap"}) {
    folder_.Write(std::filesystem::path("published") / theirs, "kept");
    const auto refused = Publish(1, {});
    ASSERT_FALSE(refused) << theirs;
    EXPECT_EQ(refused.error().code, ErrorCode::kBadInput);
    EXPECT_THAT(refused.error().message, HasSubstr("was not published by rigcal, and is kept"));
    EXPECT_FALSE(*store_->InForce("studio")) << theirs;
    EXPECT_EQ(*ReadFile(target_.folder / theirs), "kept");
    std::filesystem::remove_all(target_.folder);
  }
  std::filesystem::create_directories(target_.folder);
  std::filesystem::create_directory_symlink(folder_.Path(), target_.folder / "colmap");
  EXPECT_FALSE(Publish(1, {}));
  EXPECT_EQ(std::filesystem::read_symlink(target_.folder / "colmap"), folder_.Path());
}

TEST_F(PublishFiles, ARigDoesNotTakeTheFolderOfAnother) {
  ASSERT_TRUE(Publish(1, {}));
  const std::string before = Current();
  const int other = *store_->Append(ExampleRevision("annex", 3));
  const auto refused = PublishRevision(*store_, ExampleRequest("annex", other, {}), target_, clock_, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(refused.error().message, HasSubstr("current.json: is that of the rig \"studio\", not of 'annex'"));
  EXPECT_FALSE(*store_->InForce("annex"));
  EXPECT_EQ(Current(), before);
  folder_.Write("published/current.json", "torn by hand");
  EXPECT_TRUE(*Repair()) << "what is none of rigcal's is replaced";
}

TEST_F(PublishFiles, AFormatThatIsAskedForTwiceMovesNothing) {
  target_.formats = {{"opencv"}, {"colmap"}, {"opencv", true}};
  const auto refused = Publish(1, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("'opencv' is asked for twice"));
  EXPECT_FALSE(*store_->InForce("studio"));
}

TEST_F(PublishFiles, WhatFailsAfterThePointerMovedSaysSo) {
  folder_.Write("published/current.json/theirs.txt", "a folder gives no way to a file");
  const auto failed = Publish(1, {});
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message, HasSubstr("revision 1 of rig 'studio' is in force, but"));
  EXPECT_THAT(failed.error().message, HasSubstr("published/current.json"));
  EXPECT_EQ((*store_->InForce("studio"))->revision, 1);
}

TEST_F(PublishFiles, WhoComesSecondWaitsForTheFolder) {
  std::filesystem::create_directories(target_.folder);
  const int held = open(target_.folder.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(flock(held, LOCK_EX), 0);
  const auto late = Publish(1, {});
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kTimeout);
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = PublishRevision(*store_, ExampleRequest("studio", 1, {}), target_, clock_, stop.get_token());
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kCancelled);
  close(held);
  EXPECT_TRUE(Publish(1, {}));
}

}  // namespace
}  // namespace rigcal
