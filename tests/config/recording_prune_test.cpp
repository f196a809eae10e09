#include "config/recording_prune.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/read_file.h"
#include "config/recording_file.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using std::chrono::sys_days;
using std::chrono::year;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kPictureBytes = 1e6, kFreeBytes = 1e9;

/// A folder of recordings on the 31st of January 2025 with a gigabyte left on its disk.
class PruneTest : public ::testing::Test {
 protected:
  /// A closed recording with one picture of a megabyte, taken at noon of a day of January.
  fs::path Add(const std::string& name, int day, bool closed = true) {
    Recording recording{.id = "id-" + name, .closed = closed};
    recording.cameras = {{.id = "left", .width_px = 8, .height_px = 6}};
    recording.views = {{.file = "left/00.png",
                        .sha256 = std::string(64, 'a'),
                        .taken_at = fmt::format("2025-01-{:02}T12:00:00Z", day)}};
    folder_.Write(name + "/left/00.png", std::string(static_cast<std::size_t>(kPictureBytes), 'x'));
    return folder_.Write(name + "/recording.json", RecordingText(recording)).parent_path();
  }

  PruneReport Prune(const PruneOptions& options, const std::stop_token& stop = {}) {
    const PruneSurroundings surroundings{sys_days(year(2025) / 1 / 31) + std::chrono::hours(12),
                                         [](const fs::path&) -> Result<double> { return kFreeBytes; }};
    Result<PruneReport> report = PruneRecordings(folder_.Path(), options, surroundings, stop);
    EXPECT_TRUE(report) << Message(report);
    return report ? std::move(*report) : PruneReport{};
  }

  /// What lies in the folder, sorted.
  [[nodiscard]] std::vector<std::string> Left() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.Path())) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryFolder folder_;
};

std::vector<std::string> Reasons(const PruneReport& report) {
  std::vector<std::string> reasons;
  for (const PrunedRecording& gone : report.gone) reasons.push_back(gone.id + ": " + gone.reason);
  return reasons;
}

TEST_F(PruneTest, OldOnesGoByAge) {
  Add("a", 20), Add("b", 1), Add("c", 10);
  const PruneReport report = Prune({.rule = {.max_age_days = 15}});
  EXPECT_THAT(Reasons(report), ElementsAre("id-b: 30.0 days old (limit 15)", "id-c: 21.0 days old (limit 15)"));
  EXPECT_THAT(Left(), ElementsAre("a"));
  EXPECT_EQ(report.num_left, 1);
  EXPECT_THAT(report.remarks, IsEmpty());
}

TEST_F(PruneTest, TheOldestGoByNumber) {
  Add("a", 20), Add("b", 1), Add("c", 10);
  EXPECT_THAT(Reasons(Prune({.rule = {.max_count = 2}})), ElementsAre("id-b: the oldest of 3 recordings (limit 2)"));
  EXPECT_THAT(Left(), ElementsAre("a", "c"));
}

TEST_F(PruneTest, TheOldestGoUntilTheDiskHasRoom) {
  Add("a", 20), Add("b", 1), Add("c", 10);
  const PruneReport report = Prune({.rule = {.min_free_bytes = kFreeBytes + 1.5 * kPictureBytes}});
  EXPECT_THAT(Reasons(report), ElementsAre("id-b: 1.000 GB of the disk are free (limit 1.0015)",
                                           "id-c: 1.001 GB of the disk are free (limit 1.0015)"));
  EXPECT_THAT(report.gone[0].bytes,
              ::testing::AllOf(::testing::Gt(kPictureBytes), ::testing::Lt(1.01 * kPictureBytes)));
  EXPECT_THAT(Left(), ElementsAre("a"));
}

TEST_F(PruneTest, NothingGoesWithoutARule) {
  Add("a", 1);
  EXPECT_THAT(Prune({}).gone, IsEmpty());
  EXPECT_THAT(Left(), ElementsAre("a"));
}

TEST_F(PruneTest, WhatIsNeededStaysAndIsNamed) {
  Add("a", 1), Add("b", 2), Add("c", 3);
  const PruneReport report = Prune({.rule = {.max_age_days = 5, .max_count = 1}, .needed = {"id-a", "b", "night"}});
  EXPECT_THAT(Left(), ElementsAre("a", "b")) << "by its id or by its folder's name";
  EXPECT_THAT(report.remarks, ElementsAre(HasSubstr("a: 30.0 days old (limit 5), stays because it is needed"),
                                          HasSubstr("b: 29.0 days old (limit 5), stays because it is needed"),
                                          "there is no closed recording 'night' to be kept",
                                          "2 recordings stay (limit 1): nothing else may go"));
}

TEST_F(PruneTest, WhatARevisionWasMadeFromStays) {
  Add("a", 1), Add("b", 2), Add("c", 3), Add("d", 30);
  const std::string of_b = Sha256Hex(*ReadFile(folder_.Path() / "b" / kRecordingFile));
  const PruneReport report = Prune({.rule = {.max_age_days = 5}, .of_revisions = {"id-a", of_b, "elsewhere"}});
  EXPECT_THAT(Left(), ElementsAre("a", "b", "d")) << "by its id, or by its list's checksum where no id is known";
  EXPECT_THAT(report.remarks, ElementsAre(HasSubstr("a: 30.0 days old (limit 5), stays because a revision was made"),
                                          HasSubstr("b: 29.0 days old (limit 5), stays because a revision was made")))
      << "revisions are made from recordings that lie elsewhere, too";
}

TEST_F(PruneTest, WhatIsNoWholeRecordingIsLeftAlone) {
  Add("open", 1, false), Add("notes", 1);
  folder_.Write("notes/notes.txt", "kept by hand");
  folder_.Write("broken/recording.json", "{");
  folder_.Write("photographs/00.png", "x");
  folder_.Write("file", "x");
  const TemporaryFolder elsewhere;
  fs::create_directory_symlink(elsewhere.Path(), folder_.Path() / "link");
  folder_.Write("link/recording.json", "{}");
  const PruneReport report = Prune({.rule = {.max_age_days = 5, .max_count = 1, .min_free_bytes = 2 * kFreeBytes}});
  EXPECT_THAT(report.gone, IsEmpty());
  EXPECT_THAT(Left(), ElementsAre("broken", "file", "link", "notes", "open", "photographs"));
  EXPECT_TRUE(fs::exists(elsewhere.Path() / "recording.json"));
  EXPECT_THAT(report.remarks, Contains(HasSubstr("open: left alone: the recording is not closed")));
  EXPECT_THAT(report.remarks, Contains(HasSubstr("notes: left alone: notes.txt is not part of the recording")));
  EXPECT_THAT(report.remarks, Contains(HasSubstr("broken: left alone: ")));
  EXPECT_THAT(report.remarks, Contains("1.000 GB of the disk are free (limit 2): nothing else may go"));
}

TEST_F(PruneTest, ALinkInARecordingIsNotItsOwn) {
  const fs::path recording = Add("a", 1);
  const TemporaryFolder elsewhere;
  fs::create_directory_symlink(elsewhere.Path(), recording / "more");
  EXPECT_THAT(Prune({.rule = {.max_age_days = 5}}).gone, IsEmpty());
  EXPECT_THAT(Left(), ElementsAre("a"));
}

TEST_F(PruneTest, ATemporaryFileOfAnInterruptedWriteGoesWithIt) {
  Add("a", 1);
  folder_.Write("a/.recording.json.Ab3dE6", "{");
  EXPECT_EQ(Prune({.rule = {.max_age_days = 5}}).gone.size(), 1u);
  EXPECT_THAT(Left(), IsEmpty());
}

TEST_F(PruneTest, ADryRunTouchesNothing) {
  Add("a", 1), Add("b", 2), Add("c", 30);
  folder_.Write(".d.pruned/left/00.png", "x");
  const PruneReport report = Prune({.rule = {.max_count = 1}, .dry_run = true});
  EXPECT_EQ(report.gone.size(), 2u);
  EXPECT_EQ(report.num_left, 1);
  EXPECT_THAT(Left(), ElementsAre(".d.pruned", "a", "b", "c"));
}

TEST_F(PruneTest, WhatAnInterruptionLeftGoesWithTheNextCall) {
  Add("a", 30);
  Add(".b.pruned", 1);
  folder_.Write(".c.pruned/left/00.png", "x");
  const PruneReport report = Prune({.rule = {.max_count = 1}});
  EXPECT_THAT(report.gone, IsEmpty()) << "what has the name of one to be removed is no recording any more";
  EXPECT_EQ(report.num_left, 1);
  EXPECT_THAT(Left(), ElementsAre("a"));
}

TEST_F(PruneTest, WithoutATimeInItThatOfTheFileCounts) {
  const fs::path recording = Add("a", 1);
  Recording untimed = *LoadRecording(recording);
  untimed.views[0].taken_at.reset();
  const fs::path file = folder_.Write("a/recording.json", RecordingText(untimed));
  EXPECT_THAT(Prune({.rule = {.max_age_days = 5}}).gone, IsEmpty()) << "written just now";
  const auto old = sys_days(year(2025) / 1 / 1) + std::chrono::hours(12);
  fs::last_write_time(file,
                      fs::file_time_type::clock::from_sys(std::chrono::time_point_cast<std::chrono::seconds>(old)));
  EXPECT_THAT(Reasons(Prune({.rule = {.max_age_days = 5}})), ElementsAre("id-a: 30.0 days old (limit 5)"));
}

TEST_F(PruneTest, EndsWhenAskedAndSaysWhatWent) {
  Add("a", 1), Add("b", 2);
  std::stop_source stop;
  const PruneSurroundings surroundings{sys_days(year(2025) / 1 / 31), [&](const fs::path&) -> Result<double> {
                                         stop.request_stop();  // after the recordings were found
                                         return kFreeBytes;
                                       }};
  const auto report = PruneRecordings(folder_.Path(), {.rule = {.max_count = 1}}, surroundings, stop.get_token());
  ASSERT_TRUE(report) << Message(report);
  ASSERT_TRUE(report->failure);
  EXPECT_EQ(report->failure->code, ErrorCode::kCancelled);
  EXPECT_THAT(report->gone, IsEmpty());
  EXPECT_EQ(report->num_left, 2);
  EXPECT_THAT(Left(), ElementsAre("a", "b"));
}

TEST_F(PruneTest, OneThatCannotGoIsNamedAndWhole) {
  Add("a", 1), Add("b", 2), Add("c", 3);
  folder_.Write(".b.pruned", "a file where the folder would have to be");
  const PruneReport report = Prune({.rule = {.max_count = 1}});
  ASSERT_TRUE(report.failure);
  EXPECT_EQ(report.failure->code, ErrorCode::kIo);
  EXPECT_THAT(report.failure->message, HasSubstr("b: cannot be removed"));
  EXPECT_THAT(Reasons(report), ElementsAre("id-a: the oldest of 3 recordings (limit 1)"));
  EXPECT_EQ(report.num_left, 2);
  EXPECT_THAT(Left(), ElementsAre(".b.pruned", "b", "c"));
  EXPECT_TRUE(fs::exists(folder_.Path() / "b" / kRecordingFile));
}

TEST_F(PruneTest, AFolderThatIsNotThereIsNamed) {
  const auto report = PruneRecordings(folder_.Path() / "none", {}, RealSurroundings(), {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(report.error().message, HasSubstr("none: cannot be read as a folder"));
}

TEST_F(PruneTest, TheDiskHasAsMuchRoomAsItSays) {
  const auto free_bytes = RealSurroundings().free_bytes(folder_.Path());
  ASSERT_TRUE(free_bytes) << Message(free_bytes);
  EXPECT_GT(*free_bytes, 0);
}

}  // namespace
}  // namespace rigcal
