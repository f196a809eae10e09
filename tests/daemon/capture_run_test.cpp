#include "daemon/capture_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/recording_check.h"
#include "config/recording_file.h"
#include "tests/config/temporary_folder.h"
#include "tests/drivers/scripted_devices.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uintmax_t kPicture_bytes = 64 * 48;

/// Two cameras at a table with three stops.
class CaptureRun : public ::testing::Test {
 protected:
  CaptureRun() {
    right_.seed = 1000;
    request_ = {.out = folder_.Path() / "set", .id = "night"};
    for (int s = 0; s < 3; ++s) request_.plan.stops.push_back({{fmt::format("{:02}", s), {0.5 * s}}, {0, 1}});
  }
  Result<CaptureOutcome> Run() { return CaptureRecording({{&left_, &right_}, &table_, &clock_}, request_, {}, {}); }
  [[nodiscard]] std::vector<std::string> Listed() const {
    std::vector<std::string> listed;
    const Result<Recording> recording = LoadRecording(request_.out);
    for (const RecordedView& view : recording->views) listed.push_back(view.file);
    return listed;
  }

  TemporaryFolder folder_;
  FakeClock clock_;
  std::vector<std::string> log_;
  ScriptedCamera left_{"left", clock_, log_}, right_{"right/2", clock_, log_};
  ScriptedPositioner table_{clock_, log_};
  CaptureRequest request_;
};

TEST_F(CaptureRun, GivesAWholeRecording) {
  const Result<CaptureOutcome> outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  const auto findings = CheckRecording(request_.out, {});
  ASSERT_TRUE(findings);
  EXPECT_THAT(findings->faults, IsEmpty());
  EXPECT_THAT(findings->remarks, IsEmpty());
  EXPECT_EQ(findings->recording.id, "night");
  EXPECT_TRUE(findings->recording.linear);
  EXPECT_EQ(findings->recording.stops[2].axes.front().commanded, 1.0);
  EXPECT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png", "left_01.png", "right_2_01.png", "left_02.png",
                                    "right_2_02.png"));
}

TEST_F(CaptureRun, NamesThatWouldBeOneAreTwoFiles) {
  ScriptedCamera left_x("left_x", clock_, log_);
  left_x.seed = 1000;
  request_.plan.stops = {{{"x_1", {0}}, {0, 1}}, {{"1", {0.5}}, {0, 1}}};
  const auto outcome = CaptureRecording({{&left_, &left_x}, &table_, &clock_}, request_, {}, {});
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(Listed(), ElementsAre("left_x_1.png", "left_x_x_1.png", "left_1.png", "left_x_1~2.png"));
  EXPECT_THAT(CheckRecording(request_.out, {})->faults, IsEmpty());
}

TEST_F(CaptureRun, WithoutRoomOnTheDiskNothingBegins) {
  const std::uintmax_t needed = 6 * kPicture_bytes + kReserve_bytes;
  request_.free_bytes = [&](const std::filesystem::path&) { return Result<std::uintmax_t>(needed - 1); };
  const Result<CaptureOutcome> outcome = Run();
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kDiskFull);
  EXPECT_THAT(outcome.error().message, HasSubstr(fmt::format("{} bytes are free", needed - 1)));
  EXPECT_THAT(outcome.error().message, HasSubstr(fmt::format("6 pictures need {}", needed)));
  EXPECT_THAT(log_, IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(request_.out));
  request_.free_bytes = [&](const std::filesystem::path&) { return Result<std::uintmax_t>(needed); };
  EXPECT_TRUE(Run());
}

TEST_F(CaptureRun, AnInterruptedOneIsKeptAndResumed) {
  table_.failing_stop = "01";
  ASSERT_FALSE(Run());
  EXPECT_FALSE(LoadRecording(request_.out)->closed);
  EXPECT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png"));
  right_.script = {{2, ShotKind::kDark}, {3, ShotKind::kDark}, {4, ShotKind::kDark}};
  table_.failing_stop.clear();
  request_.resume = true;
  ASSERT_FALSE(Run());
  EXPECT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png", "left_01.png", "right_2_01.png", "left_02.png"));
  log_.clear();
  const Result<CaptureOutcome> outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(log_, ElementsAre("home", "move 02", "ready right/2", "fire right/2", "collect right/2"));
  EXPECT_EQ(outcome->acquisition.num_pictures, 1);
  EXPECT_TRUE(outcome->recording.closed);
  EXPECT_THAT(CheckRecording(request_.out, {})->faults, IsEmpty());
}

TEST_F(CaptureRun, ResumingNeedsTheSameCameras) {
  table_.failing_stop = "01";
  ASSERT_FALSE(Run());
  request_.resume = true;
  ScriptedCamera other("middle", clock_, log_);
  const auto outcome = CaptureRecording({{&left_, &other}, &table_, &clock_}, request_, {}, {});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(outcome.error().message, HasSubstr("'middle'"));
  request_.subject = Subject::kChart;
  const auto other_subject = Run();
  ASSERT_FALSE(other_subject);
  EXPECT_THAT(other_subject.error().message,
              HasSubstr("view 'left_00.png' of the recording shows the object, not the chart"));
  left_.linear = right_.linear = false;
  const auto other_kind = Run();
  ASSERT_FALSE(other_kind);
  EXPECT_THAT(other_kind.error().message, HasSubstr("pictures are linear, the rig's cameras give gamma-encoded ones"));
}

TEST_F(CaptureRun, ResumingNeedsTheSamePlaces) {
  right_.script = {{1, ShotKind::kDark}, {2, ShotKind::kDark}, {3, ShotKind::kDark}};
  ASSERT_FALSE(Run());
  ASSERT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png", "left_01.png"));
  request_.resume = true;
  log_.clear();
  AcquisitionPlan& plan = request_.plan;
  plan.stops[1].target.axes = {0.6};  // the other picture of the stop was taken at 0.5
  const auto elsewhere = Run();
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(elsewhere.error().message, HasSubstr("stop '01' of the recording is at [0.5] (rad or m), not at [0.6]"));
  plan.stops[1].target.axes = {0.5, 0.1};
  EXPECT_THAT(Run().error().message, HasSubstr("not at [0.5, 0.1]"));
  plan.stops.resize(1);
  const auto fewer = Run();
  ASSERT_FALSE(fewer) << "a stop that lacks a picture would be taken for a whole one";
  EXPECT_THAT(fewer.error().message, HasSubstr("stop '01' of the recording is none of those that are asked for"));
  EXPECT_FALSE(LoadRecording(request_.out)->closed);
  EXPECT_THAT(log_, IsEmpty()) << "nothing moves";
}

/// The same cameras at an arm that says its stops itself.
class CaptureArm : public CaptureRun {
 protected:
  CaptureArm() {
    request_.plan.stops.clear();
    request_.plan.cameras_at = [](const RecordedStop&) -> Result<std::vector<int>> { return std::vector{0, 1}; };
  }
  static RecordedStop At(const std::string& id, double x_m) {
    const Rigid3d pose{Eigen::Quaterniond::Identity(), {x_m, 0, 0}};
    return {.id = id, .base_from_flange_commanded = pose, .base_from_flange_reported = pose};
  }
  Result<CaptureOutcome> RunArm(std::vector<RecordedStop> told) {
    arm_.emplace(clock_, log_);
    arm_->told = std::move(told);
    return CaptureRecording({{&left_, &right_}, &*arm_, &clock_}, request_, {}, {});
  }
  std::optional<ScriptedPositioner> arm_;
};

TEST_F(CaptureArm, GivesAWholeRecordingWithItsPoses) {
  const Result<CaptureOutcome> outcome = RunArm({At("near", 0.1), At("far", 0.4)});
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(CheckRecording(request_.out, {})->faults, IsEmpty());
  EXPECT_THAT(Listed(), ElementsAre("left_near.png", "right_2_near.png", "left_far.png", "right_2_far.png"));
  EXPECT_EQ(outcome->recording.stops[1].base_from_flange_reported->translation.x(), 0.4);
}

TEST_F(CaptureArm, IsResumedByTheSameProgramAgain) {
  right_.gone_from_s = 2.5;  // while the second stop is taken
  ASSERT_FALSE(RunArm({At("00", 0), At("01", 0.1), At("02", 0.2)}));
  EXPECT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png", "left_01.png"));
  right_.gone_until_s = 0;
  request_.resume = true;
  const auto elsewhere = RunArm({At("00", 0.001), At("01", 0.1)});
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(elsewhere.error().message, HasSubstr("stop '00' of the recording is 0.001000 m and 0.000000 rad from"));
  const auto passed_over = RunArm({At("02", 0.2)});
  ASSERT_FALSE(passed_over);
  EXPECT_THAT(passed_over.error().message, HasSubstr("stop '01' lacks 1 of 2 pictures"));
  EXPECT_FALSE(LoadRecording(request_.out)->closed);
  const auto outcome = RunArm({At("00", 0.00005), At("01", 0.1), At("02", 0.2)});
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_EQ(outcome->acquisition.num_pictures, 1);
  EXPECT_EQ(arm_->finished.size(), 3) << "also those that have their pictures are answered";
  EXPECT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png", "left_01.png", "right_2_01.png", "left_02.png",
                                    "right_2_02.png"));
}

TEST_F(CaptureArm, WithoutRoomForAStopItIsNotTaken) {
  int asked = 0;
  request_.free_bytes = [&](const std::filesystem::path&) {
    return Result<std::uintmax_t>(kReserve_bytes + 2 * kPicture_bytes - (++asked == 3 ? 1 : 0));
  };
  const auto outcome = RunArm({At("00", 0), At("01", 0.1)});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kDiskFull);
  EXPECT_THAT(outcome.error().message, HasSubstr("2 pictures need"));
  EXPECT_THAT(Listed(), ElementsAre("left_00.png", "right_2_00.png"));
}

TEST_F(CaptureArm, WithoutAnyStopThereIsNoRecording) {
  const auto outcome = RunArm({});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kDevice);
}

TEST_F(CaptureRun, CamerasAreOfOneKind) {
  right_.linear = false;
  const Result<CaptureOutcome> outcome = Run();
  ASSERT_FALSE(outcome);
  EXPECT_THAT(outcome.error().message, HasSubstr("'right/2'"));
}

TEST_F(CaptureRun, AFolderWithSomethingInItIsRefused) {
  folder_.Write("set/notes.txt", "the operator's");
  const Result<CaptureOutcome> outcome = Run();
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kBadInput);
  EXPECT_THAT(log_, IsEmpty());
}

TEST(BytesNeeded, CountsChannelsAndDepth) {
  FakeClock clock;
  std::vector<std::string> log;
  const std::pair<const char*, int> cases[] = {{"Mono8", 1}, {"Mono12", 2}, {"BayerRG8", 3}, {"BayerRG12", 6}, {"", 3}};
  for (const auto& [format, bytes_per_pixel] : cases) {
    ScriptedCamera camera("cam", clock, log, format);
    const AcquisitionPlan plan{.stops = {{{"0", {}}, {0}}, {{"1", {}}, {0}}}};
    EXPECT_EQ(BytesNeeded({{&camera}, nullptr, &clock}, plan), 2 * kPicture_bytes * bytes_per_pixel) << format;
  }
}

}  // namespace
}  // namespace rigcal
