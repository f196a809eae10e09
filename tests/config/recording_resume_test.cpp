#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/read_file.h"
#include "config/recording_check.h"
#include "config/recording_file.h"
#include "config/recording_writer.h"
#include "tests/config/example_recording.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A recording of one camera at two stops, of which it has the first picture.
class RecordingResume : public ::testing::Test {
 protected:
  void SetUp() override {
    Result<RecordingWriter> writer = RecordingWriter::Create(Path(), "set", false);
    ASSERT_TRUE(writer && writer->AddCamera({.id = "cam", .width_px = 8, .height_px = 6}));
    ASSERT_TRUE(writer->AddStop({.id = "0"}) && writer->AddStop({.id = "1"}));
    ASSERT_TRUE(writer->AddView(ViewAt(0), PngBytes(8, 6, 90)));
  }
  [[nodiscard]] std::filesystem::path Path() const { return folder_.Path() / "set"; }
  static RecordedView ViewAt(int stop) {
    return {.file = fmt::format("v{}.png", stop), .camera = 0, .stop = stop, .subject = Subject::kObject};
  }

  TemporaryFolder folder_;
};

TEST_F(RecordingResume, GoesOnToAWholeRecording) {
  Result<RecordingWriter> writer = RecordingWriter::Resume(Path());
  ASSERT_TRUE(writer) << Message(writer);
  EXPECT_EQ(writer->Content().views.size(), 1);
  ASSERT_TRUE(writer->AddView(ViewAt(1), PngBytes(8, 6, 91)));
  ASSERT_TRUE(writer->Close());
  const auto findings = CheckRecording(Path(), {});
  ASSERT_TRUE(findings);
  EXPECT_THAT(findings->faults, IsEmpty());
  EXPECT_THAT(findings->remarks, IsEmpty());
  EXPECT_EQ(findings->recording.views.size(), 2);
}

TEST_F(RecordingResume, RemovesTemporaryFilesAndReplacesWhatWasNotListed) {
  folder_.Write("set/.recording.json.aB3xY9", "half");
  folder_.Write("set/.v1.png.000000", "half");
  folder_.Write("set/v1.png", "written, and then the power went");
  folder_.Write("set/.notes", "the operator's");
  Result<RecordingWriter> writer = RecordingWriter::Resume(Path());
  ASSERT_TRUE(writer) << Message(writer);
  ASSERT_TRUE(writer->AddView(ViewAt(1), PngBytes(8, 6, 91)));
  ASSERT_TRUE(writer->Close());
  const auto findings = CheckRecording(Path(), {});
  EXPECT_THAT(findings->faults, IsEmpty());
  EXPECT_THAT(findings->remarks, ElementsAre(HasSubstr(".notes")));
}

TEST_F(RecordingResume, WhatIsListedIsNotTakenAgain) {
  Result<RecordingWriter> writer = RecordingWriter::Resume(Path());
  ASSERT_TRUE(writer);
  EXPECT_FALSE(writer->AddView(ViewAt(0), PngBytes(8, 6, 99)));
  EXPECT_EQ(*ReadFile(Path() / "v0.png"), PngBytes(8, 6, 90));
}

TEST_F(RecordingResume, AClosedOneIsRefused) {
  ASSERT_TRUE(RecordingWriter::Resume(Path())->Close());
  ExpectRefused(RecordingWriter::Resume(Path()), {"set", "closed"});
}

TEST_F(RecordingResume, AListedPictureThatIsGoneIsRefused) {
  std::filesystem::remove(Path() / "v0.png");
  ExpectRefused(RecordingWriter::Resume(Path()), {"v0.png", "not there"});
}

TEST_F(RecordingResume, NoneAtAll) {
  EXPECT_EQ(RecordingWriter::Resume(folder_.Path() / "other").error().code, ErrorCode::kNotFound);
}

TEST_F(RecordingResume, ClosesInTheOrderThatIsAskedFor) {
  Result<RecordingWriter> writer = RecordingWriter::Resume(Path());
  ASSERT_TRUE(writer->AddStop({.id = "2"}));
  ASSERT_TRUE(writer->AddView(ViewAt(2), PngBytes(8, 6, 92)));
  ASSERT_TRUE(writer->AddView(ViewAt(1), PngBytes(8, 6, 91)));
  ASSERT_TRUE(writer->Close({.stops = {"2", "0"}, .views = {"v1.png", "v2.png"}}));
  const Result<Recording> recording = LoadRecording(Path());
  ASSERT_TRUE(recording) << Message(recording);
  std::vector<std::string> listed;
  for (const RecordedStop& stop : recording->stops) listed.push_back(stop.id);
  for (const RecordedView& view : recording->views) {
    listed.push_back(view.file + " at " + recording->stops[*view.stop].id);
  }
  EXPECT_THAT(listed, ElementsAre("2", "0", "1", "v1.png at 1", "v2.png at 2", "v0.png at 0"));
}

}  // namespace
}  // namespace rigcal
