#include "config/recording_import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "config/read_file.h"
#include "config/recording_check.h"
#include "config/stop_angles.h"
#include "tests/config/example_recording.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kRadPerDeg = std::numbers::pi / 180;

/// Two cameras at the stops 9, 10 and 11 of a table; and a text.
class ImportTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* stop : {"9", "10", "11"}) {
      folder_.Write(fmt::format("in/left_{}.png", stop), PngBytes(8, 6, 50));
      folder_.Write(fmt::format("in/right_{}.PNG", stop), PngBytes(10, 4, 60));
    }
    folder_.Write("in/readme.txt", "no picture");
    from_ = {.folder = folder_.Path() / "in",
             .camera_from_name = "^([a-z]+)_",
             .stop_from_name = "_([0-9]+)",
             .angles_deg = "10:30",
             .subject = Subject::kChart};
  }
  Result<Recording> Import(std::stop_token stop = {}) { return ImportRecording(from_, Out(), {.stop = stop}); }
  [[nodiscard]] std::filesystem::path Out() const { return folder_.Path() / "out"; }
  /// Names in the folder of the recording's folder: what a failure left behind would be there.
  [[nodiscard]] std::vector<std::string> Beside() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.Path()))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryFolder folder_;
  PictureFolder from_;
};

TEST_F(ImportTest, CopiesPicturesWithCamerasAndStops) {
  const Result<Recording> recording = Import();
  ASSERT_TRUE(recording) << Message(recording);
  EXPECT_THAT(Beside(), ElementsAre("in", "out"));
  EXPECT_TRUE(recording->closed);
  EXPECT_EQ(recording->id, "out");
  ASSERT_EQ(recording->cameras.size(), 2U);
  EXPECT_EQ(recording->cameras[1].id, "right");
  EXPECT_EQ(recording->cameras[1].width_px, 10);
  ASSERT_EQ(recording->stops.size(), 3U);
  EXPECT_EQ(recording->stops[0].id, "9") << "by number, not by characters";
  EXPECT_NEAR(recording->stops[2].axes[0].commanded, 70 * kRadPerDeg, 1e-15);
  ASSERT_EQ(recording->views.size(), 6U);
  for (const RecordedView& view : recording->views) {
    EXPECT_EQ(view.subject, Subject::kChart);
    EXPECT_EQ(*ReadFile(Out() / view.file), *ReadFile(folder_.Path() / "in" / view.file));
    EXPECT_THAT(view.file, HasSubstr(recording->stops[*view.stop].id));
  }
  const auto findings = CheckRecording(Out(), {});
  ASSERT_TRUE(findings);
  EXPECT_THAT(findings->faults, IsEmpty());
  EXPECT_THAT(findings->remarks, IsEmpty());
}

TEST_F(ImportTest, OneCameraAndNoStopsWithoutPatterns) {
  std::filesystem::remove_all(folder_.Path() / "in");
  folder_.Write("in/a.png", PngBytes(8, 6, 50));
  from_.camera_from_name = from_.stop_from_name = from_.angles_deg = "";
  const Result<Recording> recording = Import();
  ASSERT_TRUE(recording) << Message(recording);
  EXPECT_EQ(recording->cameras[0].id, "camera");
  EXPECT_FALSE(recording->views[0].stop);
}

TEST_F(ImportTest, OnePictureOfAnotherSize) {
  folder_.Write("in/left_11.png", PngBytes(8, 7, 50));
  EXPECT_THAT(Message(Import()), AllOf(HasSubstr("left_11.png: the image is 8 x 7 px"), HasSubstr("'left_10.png'"),
                                       HasSubstr("camera 'left' is 8 x 6 px")));
  EXPECT_THAT(Beside(), ElementsAre("in"));
}

TEST_F(ImportTest, APictureThatIsNone) {
  folder_.Write("in/right_9.PNG", "text");
  EXPECT_THAT(Message(Import()), HasSubstr("right_9.PNG"));
  EXPECT_THAT(Beside(), ElementsAre("in"));
}

TEST_F(ImportTest, NothingIsWrittenOver) {
  folder_.Write("out/precious.txt", "mine");
  EXPECT_THAT(Message(Import()), AllOf(HasSubstr("out: is there already"), HasSubstr("not empty")));
  EXPECT_EQ(*ReadFile(Out() / "precious.txt"), "mine");
  EXPECT_THAT(Beside(), ElementsAre("in", "out"));
}

TEST_F(ImportTest, AnEmptyFolderIsFilled) {
  std::filesystem::create_directory(Out());
  EXPECT_TRUE(Import());
}

TEST_F(ImportTest, StoppedInTheMiddleLeavesNothing) {
  std::stop_source stop;
  const Result<Recording> recording =
      ImportRecording(from_, Out(), {.stop = stop.get_token(), .report_progress = [&](double share) {
                                       if (share > 0.4) stop.request_stop();
                                     }});
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().code, ErrorCode::kCancelled);
  EXPECT_THAT(Beside(), ElementsAre("in"));
}

TEST_F(ImportTest, NamesThatDoNotFit) {
  from_.camera_from_name = "(left)";
  EXPECT_THAT(Message(Import()), AllOf(HasSubstr("camera from name"), HasSubstr("'right_10.PNG'")));
  from_.camera_from_name = "(";
  EXPECT_THAT(Message(Import()), HasSubstr("not a regular expression"));
  from_.camera_from_name = "^([a-z]+)_";
  from_.stop_from_name = "_(1)";
  EXPECT_THAT(Message(Import()), AllOf(HasSubstr("stop from name"), HasSubstr("'left_9.png'")));
  from_.stop_from_name = "";
  EXPECT_THAT(Message(Import()), HasSubstr("--angles-deg needs --stop-from-name"));
}

TEST_F(ImportTest, TwoPicturesForOneStop) {
  from_.stop_from_name = "(.)[.]";
  folder_.Write("in/left_19.png", PngBytes(8, 6, 50));
  from_.angles_deg = "";
  EXPECT_THAT(Message(Import()), AllOf(HasSubstr("'left_9.png'"), HasSubstr("at stop '9'")));
  EXPECT_THAT(Beside(), ElementsAre("in"));
}

TEST_F(ImportTest, NoPictureAndNoFolder) {
  from_.folder = folder_.Path() / "nowhere";
  EXPECT_THAT(Message(Import()), HasSubstr("nowhere"));
  std::filesystem::create_directory(from_.folder);
  EXPECT_THAT(Message(Import()), HasSubstr("there is no picture in this folder"));
}

TEST_F(ImportTest, AnglesOfAFile) {
  from_.angles_deg = folder_.Write("angles.txt", "# stop angle\n9 -5\n\n10 90.5  # half\n11 180\n12 200\n").string();
  const Result<Recording> recording = Import();
  ASSERT_TRUE(recording) << Message(recording);
  ASSERT_EQ(recording->stops.size(), 4U) << "a stop that no camera saw is a stop";
  EXPECT_NEAR(recording->stops[0].axes[0].commanded, -5 * kRadPerDeg, 1e-15);
  EXPECT_NEAR(recording->stops[3].axes[0].commanded, 200 * kRadPerDeg, 1e-15);
}

TEST(StopAngles, BadFiles) {
  TemporaryFolder folder;
  const auto angles = [&](const char* text) {
    return Message(StopAngles(folder.Write("angles.txt", text).string(), {"1", "2"}));
  };
  EXPECT_THAT(angles("1 10\n"), AllOf(HasSubstr("angles.txt"), HasSubstr("no angle for stop '2'")));
  EXPECT_THAT(angles("1 10\n2\n"), AllOf(HasSubstr("line 2"), HasSubstr("1 fields")));
  EXPECT_THAT(angles("1 10\n2 ten\n"), AllOf(HasSubstr("line 2"), HasSubstr("ten")));
  EXPECT_THAT(angles("1 10\n1 20\n"), AllOf(HasSubstr("line 2"), HasSubstr("twice")));
  EXPECT_THAT(Message(StopAngles("nowhere.txt", {"1"})), HasSubstr("nowhere.txt"));
}

TEST(StopAngles, StartAndStepNeedStopsWithoutGaps) {
  EXPECT_THAT(Message(StopAngles("0:10", {"1", "2", "4"})), AllOf(HasSubstr("'2' to '4'"), HasSubstr("gaps")));
  EXPECT_NEAR(StopAngles("0:10", {"10", "20", "30"})->at("30"), 20 * kRadPerDeg, 1e-15);
  EXPECT_THAT(Message(StopAngles("-5:-10", {"s01", "s02", "s04"})), AllOf(HasSubstr("'s01'"), HasSubstr("numbers")));
  EXPECT_NEAR(StopAngles("-5:-10", {"1", "2", "3"})->at("3"), -25 * kRadPerDeg, 1e-15);
}

}  // namespace
}  // namespace rigcal
