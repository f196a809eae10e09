#include "config/recording_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "config/read_file.h"
#include "config/recording_check.h"
#include "config/recording_pictures.h"
#include "config/recording_writer.h"
#include "core/base/ensure.h"
#include "tests/config/example_recording.h"
#include "tests/config/refusals.h"
#include "tests/config/schema_check.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RecordingText, ReadsBackTheSame) {
  const Recording written = ExampleRecording();
  const std::string text = RecordingText(written);
  const Result<Recording> read = ParseRecording(text, "recording.json");
  ASSERT_TRUE(read) << Message(read);
  EXPECT_EQ(RecordingText(*read), text);
  EXPECT_EQ(read->cameras[0].focus_m, 0.75);
  EXPECT_EQ(read->stops[0].axes[0].reported, 0.1001);
  EXPECT_EQ(read->stops[0].axes[1].unit, AxisUnit::kMetre);
  EXPECT_FALSE(read->stops[0].axes[1].reported);
  const Rigid3d &pose = *read->stops[1].base_from_flange_reported, &truth = *written.stops[1].base_from_flange_reported;
  EXPECT_EQ(pose.rotation.coeffs(), truth.rotation.coeffs());
  EXPECT_EQ(pose.translation, truth.translation);
  EXPECT_EQ(read->views[0].subject, Subject::kBoth);
  EXPECT_EQ(read->views[0].stop, 0);
  EXPECT_EQ(read->views[1].camera, 1);
  EXPECT_FALSE(read->views[2].stop);
  EXPECT_TRUE(read->closed && read->linear);
}

TEST(RecordingText, FollowsItsSchema) {
  const std::string text = RecordingText(ExampleRecording());
  EXPECT_EQ(SchemaComplaints("recording.schema.json", text), "");
  EXPECT_NE(SchemaComplaints("recording.schema.json", Replaced(text, "commanded_rad", "commanded_deg")), "");
  EXPECT_NE(SchemaComplaints("recording.schema.json", Replaced(text, "reported_rad", "reported_m")), "");
}

TEST(RecordingText, TruncatedAnywhereIsRefused) {
  const std::string text = RecordingText(ExampleRecording());
  for (std::size_t length = 0; length + 2 < text.size(); length += 7)
    EXPECT_THAT(Message(ParseRecording(text.substr(0, length), "x.json")),
                AllOf(HasSubstr("x.json: "), HasSubstr("line")))
        << length;
}

TEST(RecordingText, NewerVersionAndOtherFormatAreRefused) {
  const std::string text = RecordingText(ExampleRecording());
  const auto newer = ParseRecording(Replaced(text, "\"version\": 1", "\"version\": 2"), "x.json");
  ASSERT_FALSE(newer);
  EXPECT_EQ(newer.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(newer.error().message, AllOf(HasSubstr("version 2"), HasSubstr("up to 1")));
  EXPECT_THAT(Message(ParseRecording(Replaced(text, "rigcal recording", "rigcal calibration"), "x.json")),
              HasSubstr("the format is not"));
}

struct Spoilt {
  const char *from, *to, *words;
};

class SpoiltRecording : public ::testing::TestWithParam<Spoilt> {};

TEST_P(SpoiltRecording, IsRefusedWithASentence) {
  const std::string text = RecordingText(ExampleRecording());
  EXPECT_THAT(Message(ParseRecording(Replaced(text, GetParam().from, GetParam().to), "x.json")),
              AllOf(HasSubstr("x.json: "), HasSubstr(GetParam().words)));
}

INSTANTIATE_TEST_SUITE_P(
    Recording, SpoiltRecording,
    ::testing::Values(Spoilt{"commanded_rad", "commanded_deg", "unknown key 'commanded_deg'"},
                      Spoilt{"reported_rad", "reported_m", "both radians and metres"},
                      Spoilt{"hand.png", "right.png", "the view 'right.png' is there twice"},
                      Spoilt{"\"camera\": \"right\"", "\"camera\": \"up\"",
                             "view 'right.png': there is no camera 'up'"},
                      Spoilt{"\"stop\": \"01\"", "\"stop\": \"09\"", "view 'right.png': there is no stop '09'"},
                      Spoilt{"hand.png", "../hand.png", "'../hand.png': is not a file name inside"},
                      Spoilt{"hand.png", "/hand.png", "'/hand.png': is not a file name inside"},
                      Spoilt{"hand.png", "a//hand.png", "is not a file name inside"},
                      Spoilt{"hand.png", "recording.json", "has the name of the recording's list"},
                      Spoilt{"\"width_px\": 8", "\"width_px\": 0", "width_px is 0"},
                      Spoilt{"\"focus_m\": 0.75", "\"focus_m\": -1", "focus_m is -1"},
                      Spoilt{"aaaa", "AAAA", "64 hexadecimal digits"},
                      Spoilt{"\"subject\": \"chart\"", "\"subject\": \"board\"", "subject is 'board'"},
                      Spoilt{"59.25Z", "59.25", "taken_at is"}, Spoilt{"\"closed\": true", "\"closed\": 1", "closed"}));

TEST(RecordingConsistency, OnePictureOfACameraAtAStop) {
  Recording recording = ExampleRecording();
  recording.views[2].stop = 1;
  EXPECT_TRUE(CheckConsistent(recording)) << "chart and object at one stop are two pictures";
  recording.views[2].subject = Subject::kObject;
  EXPECT_THAT(Message(CheckConsistent(recording)),
              AllOf(HasSubstr("'hand.png'"), HasSubstr("'right'"), HasSubstr("another picture (object) at stop '01'")));
}

TEST(RecordingConsistency, DoubledIds) {
  Recording cameras = ExampleRecording(), stops = ExampleRecording();
  cameras.cameras[1].id = "left";
  EXPECT_THAT(Message(CheckConsistent(cameras)), HasSubstr("the camera 'left' is there twice"));
  stops.stops[1].id = "00";
  EXPECT_THAT(Message(CheckConsistent(stops)), HasSubstr("the stop '00' is there twice"));
  stops.stops[1].id = "01";
  stops.stops[0].axes[1].axis = "table";
  EXPECT_THAT(Message(CheckConsistent(stops)), HasSubstr("stop '00': axis 'table' is there twice"));
}

TEST(RecordingConsistency, TwoCamerasWithOneSerialNumber) {
  Recording recording = ExampleRecording();
  recording.cameras[1].serial = "S1";
  EXPECT_THAT(Message(CheckConsistent(recording)), HasSubstr("serial number 'S1'"));
}

/// A recording of one camera at two stops, as it is written.
class RecordingFolder : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path Path() const { return folder_.Path() / "set"; }
  [[nodiscard]] std::filesystem::path List() const { return Path() / kRecordingFile; }

  RecordingWriter Begin() {
    Result<RecordingWriter> writer = RecordingWriter::Create(Path(), "set", false);
    EXPECT_TRUE(writer && writer->AddCamera({.id = "cam", .width_px = 8, .height_px = 6}));
    EXPECT_TRUE(writer->AddStop({.id = "0"}) && writer->AddStop({.id = "1"}));
    return std::move(*writer);
  }
  static RecordedView ViewAt(int stop) {
    return {.file = fmt::format("v{}.png", stop), .camera = 0, .stop = stop, .subject = Subject::kObject};
  }
  void WriteWhole() {
    RecordingWriter writer = Begin();
    ASSERT_TRUE(writer.AddView(ViewAt(0), PngBytes(8, 6, 90)));
    ASSERT_TRUE(writer.AddView(ViewAt(1), PngBytes(8, 6, 91)));
    ASSERT_TRUE(writer.Close());
  }
  RecordingFindings Check() {
    auto findings = CheckRecording(Path(), {.num_threads = 2});
    EXPECT_TRUE(findings) << Message(findings);
    return findings ? *findings : RecordingFindings{};
  }

  TemporaryFolder folder_;
};

TEST_F(RecordingFolder, WholeOneHasNoFault) {
  WriteWhole();
  const Result<Recording> recording = LoadRecording(Path());
  ASSERT_TRUE(recording) << Message(recording);
  EXPECT_TRUE(recording->closed);
  EXPECT_EQ(SchemaComplaints("recording.schema.json", *ReadFile(List())), "");
  const Result<cv::Mat> picture = LoadRecordedPicture(Path(), *recording, 1);
  ASSERT_TRUE(picture) << Message(picture);
  EXPECT_EQ(picture->at<unsigned char>(2, 3), 91);
  EXPECT_THAT(Check().faults, IsEmpty());
  EXPECT_THAT(Check().remarks, IsEmpty());
}

TEST_F(RecordingFolder, NotClosedWhenTheWriterWasKilled) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    RecordingWriter writer = Begin();
    if (!writer.AddView(ViewAt(0), PngBytes(8, 6, 90))) _exit(1);
    raise(SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  const Result<Recording> recording = LoadRecording(Path());
  ASSERT_TRUE(recording) << Message(recording);
  EXPECT_FALSE(recording->closed);
  ASSERT_EQ(recording->views.size(), 1U);
  EXPECT_TRUE(LoadRecordedPicture(Path(), *recording, 0));
  EXPECT_THAT(Check().faults, ElementsAre(HasSubstr("not closed")));
  EXPECT_THAT(Message(LoadRecordedObject(Path())), AllOf(HasSubstr("not closed"), HasSubstr("1 views")));
}

TEST_F(RecordingFolder, NothingIsWrittenOver) {
  WriteWhole();
  EXPECT_THAT(Message(RecordingWriter::Create(Path(), "set", false)), HasSubstr("empty folder"));
}

TEST_F(RecordingFolder, AClosedOneIsNotChanged) {
  RecordingWriter writer = Begin();
  ASSERT_TRUE(writer.Close());
  EXPECT_THROW(static_cast<void>(writer.AddStop({.id = "2"})), BrokenPromise);
}

TEST_F(RecordingFolder, ARefusedStepLeavesTheRecordingAsItWas) {
  RecordingWriter writer = Begin();
  ASSERT_TRUE(writer.AddView(ViewAt(0), PngBytes(8, 6, 90)));
  const std::string before = *ReadFile(List());
  EXPECT_THAT(Message(writer.AddView(ViewAt(0), PngBytes(8, 6, 1))), HasSubstr("there twice"));
  EXPECT_THAT(Message(writer.AddCamera({.id = "cam", .width_px = 1, .height_px = 1})), HasSubstr("there twice"));
  RecordedView outside = ViewAt(1);
  outside.file = "../v1.png";
  EXPECT_THAT(Message(writer.AddView(outside, PngBytes(8, 6, 1))), HasSubstr("inside the recording's folder"));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path() / "v1.png"));
  EXPECT_EQ(*ReadFile(List()), before);
  EXPECT_EQ(writer.Content().views.size(), 1U);
}

TEST_F(RecordingFolder, ChangedPicture) {
  WriteWhole();
  folder_.Write("set/v1.png", PngBytes(8, 6, 92));
  EXPECT_THAT(Check().faults, ElementsAre(AllOf(HasSubstr("v1.png"), HasSubstr("SHA-256"), HasSubstr("was changed"))));
}

TEST_F(RecordingFolder, MissingPicture) {
  WriteWhole();
  std::filesystem::remove(Path() / "v0.png");
  EXPECT_THAT(Check().faults, ElementsAre(AllOf(HasSubstr("v0.png"), HasSubstr("no such file"))));
}

TEST_F(RecordingFolder, PictureOfAnotherSize) {
  RecordingWriter writer = Begin();
  ASSERT_TRUE(writer.AddView(ViewAt(0), PngBytes(8, 7, 90)));
  ASSERT_TRUE(writer.Close());
  EXPECT_THAT(Check().faults, ElementsAre(AllOf(HasSubstr("v0.png"), HasSubstr("8 x 7"), HasSubstr("8 x 6"))));
}

TEST_F(RecordingFolder, RemarksOnWhatIsOdd) {
  RecordingWriter writer = Begin();
  ASSERT_TRUE(writer.AddView(ViewAt(0), PngBytes(8, 6, 255)));
  ASSERT_TRUE(writer.Close());
  folder_.Write("set/masks/v0.png", "foreign");
  const RecordingFindings findings = Check();
  EXPECT_THAT(findings.faults, IsEmpty());
  EXPECT_THAT(findings.remarks,
              ElementsAre(AllOf(HasSubstr("v0.png"), HasSubstr("100 %"), HasSubstr("over-exposed")),
                          HasSubstr("stop '1' has no view"), HasSubstr("masks/v0.png: is not part of the recording")));
}

TEST_F(RecordingFolder, EmptyOne) {
  RecordingWriter writer = Begin();
  ASSERT_TRUE(writer.Close());
  EXPECT_THAT(Check().faults, ElementsAre(HasSubstr("the recording is empty")));
  EXPECT_THAT(Message(LoadRecordedObject(Path())), HasSubstr("the recording is empty"));
}

TEST_F(RecordingFolder, NoneAtAll) {
  EXPECT_THAT(Message(LoadRecording(Path())), AllOf(HasSubstr("recording.json"), HasSubstr("no such file")));
}

TEST_F(RecordingFolder, ObjectViewsAlone) {
  RecordingWriter writer = Begin();
  ASSERT_TRUE(writer.AddView(ViewAt(0), PngBytes(8, 6, 90)));
  RecordedView chart = ViewAt(1);
  chart.subject = Subject::kChart;
  ASSERT_TRUE(writer.AddView(chart, PngBytes(8, 6, 91)));
  ASSERT_TRUE(writer.Close());
  const Result<RecordedObject> object = LoadRecordedObject(Path());
  ASSERT_TRUE(object) << Message(object);
  EXPECT_THAT(object->camera_by_image, ElementsAre(std::pair<const std::string, std::string>("v0.png", "cam")));
  EXPECT_EQ(object->sha256_by_image.at("v0.png"), Sha256Hex(PngBytes(8, 6, 90)));
  EXPECT_EQ(object->file.sha256, Sha256Hex(*ReadFile(List())));
  RigCalibration none;
  EXPECT_THAT(Message(CheckAllHaveCameras(*object, none, "cams.txt")),
              AllOf(HasSubstr("cams.txt"), HasSubstr("v0.png")));
}

}  // namespace
}  // namespace rigcal
