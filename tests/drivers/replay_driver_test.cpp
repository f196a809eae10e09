#include "drivers/replay/replay_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/drivers/camera_contract.h"
#include "tests/drivers/positioner_contract.h"
#include "tests/support/fake_clock.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr int kNumStops = 4, kNumCameras = 2;
constexpr double kBetweenStops_s = 10;

/// A picture that no other view has.
cv::Mat PictureOf(int view) {
  cv::Mat picture(6, 8, CV_16U);
  for (int i = 0; i < static_cast<int>(picture.total()); ++i) {
    picture.at<std::uint16_t>(i) = static_cast<std::uint16_t>(1000 * view + i);
  }
  return picture;
}

int ViewOf(int camera, int stop) {
  return camera * kNumStops + stop;
}

Recording TableRecording() {
  Recording recording{.id = "night", .closed = true};
  recording.cameras = {{.id = "left", .width_px = 8, .height_px = 6},
                       {.id = "right", .width_px = 8, .height_px = 6, .serial = "S2"}};
  for (int s = 0; s < kNumStops; ++s) {
    recording.stops.push_back({.id = fmt::format("{:02}", s),
                               .axes = {{.axis = "table", .commanded = 0.5 * s, .reported = 0.5 * s + 0.0001}}});
  }
  for (int c = 0; c < kNumCameras; ++c) {
    for (int s = 0; s < kNumStops; ++s) {
      const double second = kBetweenStops_s * s + 0.25 * c;
      recording.views.push_back({.file = fmt::format("{}_{}.png", c, s),
                                 .camera = c,
                                 .stop = s,
                                 .exposure_us = 8000 + s,
                                 .taken_at = fmt::format("2025-01-31T23:59:{:05.2f}Z", second)});
    }
  }
  return recording;
}

RecordedPictures Open(Recording recording) {
  return {std::move(recording), [](int view) -> Result<CapturedPicture> {
            return CapturedPicture{.pixels = PictureOf(view), .file = PictureFile{"name", fmt::format("{}", view)}};
          }};
}

RigHardware Rig(bool at_recorded_speed) {
  RigHardware rig;
  rig.cameras = {{.id = "left", .driver = "replay"}, {.id = "right", .driver = "replay", .serial = "S2"}};
  rig.positioner = {.driver = "replay", .axes = {{.name = "table", .least = 0, .most = 3}}};
  rig.replay = {.recording = "night", .at_recorded_speed = at_recorded_speed};
  return rig;
}

/// A replay with its clock.
struct Replay {
  explicit Replay(Recording recording = TableRecording(), bool at_recorded_speed = false,
                  Subject subject = Subject::kObject) {
    DriverContext context{.clock = &clock, .subject = subject};
    context.open_recording = [&](const std::string&) -> Result<RecordedPictures> { return Open(recording); };
    driver = *MakeReplayDriver(Rig(at_recorded_speed), context, {});
    positioner = *driver->OpenPositioner(Rig(false).positioner, {});
  }
  Result<CapturedPicture> Shoot(CameraDevice& camera, int stop) {
    if (auto moved = positioner->MoveTo({fmt::format("{:02}", stop), {0.5 * stop}}, {}); !moved) {
      return Fail(moved.error());
    }
    if (auto ready = camera.MakeReady({}); !ready) return Fail(ready.error());
    if (auto fired = camera.Fire(); !fired) return Fail(fired.error());
    return camera.Collect(1, {});
  }

  FakeClock clock;
  std::unique_ptr<Driver> driver;
  std::unique_ptr<PositionerDevice> positioner;
};

class ReplayCameraPeer final : public CameraPeer {
 public:
  Clock& Time() override { return replay_.clock; }
  double SlackS() const override { return 0; }
  std::stop_token StopAfter(double seconds) override { return replay_.clock.StopAfter(seconds); }
  CameraSettings Settings() override { return Rig(false).cameras[1]; }
  Result<std::unique_ptr<CameraDevice>> Open() override { return replay_.driver->OpenCamera(Settings(), {}); }
  void Arrange(int shot) override {
    EXPECT_TRUE(replay_.positioner->MoveTo({fmt::format("{:02}", shot), {0.5 * shot}}, {}));
  }
  cv::Mat Expected(int shot) override { return PictureOf(ViewOf(1, shot)); }
  std::optional<std::string> WhyNot(CameraFault /*fault*/) override {
    return "a recording has no connection that could fail; what it lacks is tested below";
  }
  void Set(CameraFault /*fault*/, bool /*on*/) override {}
  void GoneFor(double /*seconds*/) override {}

 private:
  Replay replay_;
};

INSTANTIATE_TEST_SUITE_P(Replay, CameraContract,
                         ::testing::Values([] { return std::unique_ptr<CameraPeer>(new ReplayCameraPeer); }));

/// At recorded speed: a move takes time then.
class ReplayPositionerPeer final : public PositionerPeer {
 public:
  Clock& Time() override { return replay_.clock; }
  double SlackS() const override { return 0; }
  std::stop_token StopAfter(double seconds) override { return replay_.clock.StopAfter(seconds); }
  PositionerSettings Settings() override { return Rig(true).positioner; }
  Result<std::unique_ptr<PositionerDevice>> Open() override {
    camera_ = *replay_.driver->OpenCamera(Rig(true).cameras[0], {});
    return replay_.driver->OpenPositioner(Settings(), {});
  }
  std::vector<double> Place(int number) override { return {0.5 * number}; }
  /// Told by the picture that a camera takes there.
  std::vector<double> Position() override {
    if (!camera_->Fire()) return {-1};
    const Result<CapturedPicture> picture = camera_->Collect(0, {});
    for (int s = 0; s < kNumStops; ++s) {
      if (picture && cv::norm(picture->pixels, PictureOf(ViewOf(0, s)), cv::NORM_INF) == 0) return {0.5 * s};
    }
    return {-1};
  }
  bool Moving() override { return false; }
  std::optional<std::string> WhyNot(PositionerFault fault) override {
    if (fault == PositionerFault::kException) return std::nullopt;
    return "nothing moves in a recording, and nothing can fail on the way";
  }
  void Set(PositionerFault /*fault*/, bool /*on*/) override {
    replay_.clock.After(0.3, [] { throw std::runtime_error("in the middle of a move"); });
  }

 private:
  Replay replay_{TableRecording(), true};
  std::unique_ptr<CameraDevice> camera_;
};

INSTANTIATE_TEST_SUITE_P(Replay, PositionerContract,
                         ::testing::Values([] { return std::unique_ptr<PositionerPeer>(new ReplayPositionerPeer); }));

TEST(Replay, HandsOnWhatTheRecordingSaysOfAPicture) {
  Replay replay;
  const auto camera = *replay.driver->OpenCamera(Rig(false).cameras[0], {});
  const Result<CapturedPicture> picture = replay.Shoot(*camera, 2);
  ASSERT_TRUE(picture);
  EXPECT_EQ(picture->exposure_us, 8002);
  EXPECT_EQ(picture->taken_at, "2025-01-31T23:59:20.00Z");
  ASSERT_TRUE(picture->file);
  EXPECT_EQ(picture->file->bytes, fmt::format("{}", ViewOf(0, 2)));
}

TEST(Replay, AViewThatTheRecordingLacksIsAnErrorThatNamesIt) {
  Recording gap = TableRecording();
  gap.views.erase(gap.views.begin() + ViewOf(1, 2));
  Replay replay(gap);
  const auto camera = *replay.driver->OpenCamera(Rig(false).cameras[1], {});
  EXPECT_TRUE(replay.Shoot(*camera, 1));
  const Result<CapturedPicture> missing = replay.Shoot(*camera, 2);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kDevice);
  EXPECT_THAT(missing.error().message,
              HasSubstr("camera 'right': the recording 'night' has no picture of it at stop '02'"));
}

TEST(Replay, ShowsTheSubjectThatIsAskedFor) {
  Recording both = TableRecording();
  const int chart_view = static_cast<int>(both.views.size());
  RecordedView chart = both.views[ViewOf(0, 1)];
  chart.subject = Subject::kChart;
  both.views.push_back(chart);
  Replay object(both), of_chart(both, false, Subject::kChart);
  const auto sees_object = *object.driver->OpenCamera(Rig(false).cameras[0], {});
  const auto sees_chart = *of_chart.driver->OpenCamera(Rig(false).cameras[0], {});
  EXPECT_EQ(object.Shoot(*sees_object, 1)->file->bytes, fmt::format("{}", ViewOf(0, 1)));
  EXPECT_EQ(of_chart.Shoot(*sees_chart, 1)->file->bytes, fmt::format("{}", chart_view));
}

TEST(Replay, AStopThatTheRecordingLacksIsAnError) {
  Replay replay;
  const Result<RecordedStop> moved = replay.positioner->MoveTo({"17", {0.7}}, {});
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
  EXPECT_THAT(moved.error().message, HasSubstr("'17'"));
}

TEST(Replay, FindsAStopByItsPlaceUnderAnotherName) {
  Replay replay;
  const Result<RecordedStop> moved = replay.positioner->MoveTo({"other", {1.0}}, {});
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->id, "other");
  EXPECT_EQ(moved->axes.front().reported, 1.0001);
}

TEST(Replay, SaysItsStopsInTheirOrderWhereItStandsForAnArm) {
  Replay replay;
  const auto camera = *replay.driver->OpenCamera(Rig(false).cameras[0], {});
  for (int s = 0; s < kNumStops; ++s) {
    const auto stop = replay.positioner->NextStop({});
    ASSERT_TRUE(stop && *stop);
    EXPECT_EQ((*stop)->id, fmt::format("{:02}", s));
    ASSERT_TRUE(camera->Fire());
    EXPECT_EQ(cv::norm(camera->Collect(1, {})->pixels, PictureOf(ViewOf(0, s)), cv::NORM_INF), 0);
  }
  EXPECT_FALSE(*replay.positioner->NextStop({}));
}

TEST(Replay, FullSpeedTakesNoTimeAndRecordedSpeedTheRecorded) {
  for (const bool recorded : {false, true}) {
    Replay replay(TableRecording(), recorded);
    const auto camera = *replay.driver->OpenCamera(Rig(false).cameras[0], {});
    for (int s = 0; s < kNumStops; ++s) ASSERT_TRUE(replay.Shoot(*camera, s));
    EXPECT_EQ(replay.clock.NowS(), recorded ? kBetweenStops_s * (kNumStops - 1) : 0);
  }
}

TEST(Replay, RefusesWhatItCannotStandFor) {
  FakeClock clock;
  DriverContext context{.clock = &clock};
  Recording recording = TableRecording();
  context.open_recording = [&](const std::string&) -> Result<RecordedPictures> { return Open(recording); };
  RigHardware rig = Rig(false);
  const auto driver = *MakeReplayDriver(rig, context, {});
  rig.cameras[0].id = "middle";
  EXPECT_EQ(driver->OpenCamera(rig.cameras[0], {}).error().code, ErrorCode::kNotFound);
  rig.cameras[1].serial = "S3";
  EXPECT_THAT(driver->OpenCamera(rig.cameras[1], {}).error().message, HasSubstr("'S3'"));
  rig.positioner.axes.front().name = "z";
  EXPECT_EQ(driver->OpenPositioner(rig.positioner, {}).error().code, ErrorCode::kBadInput);
  rig.replay.recording.clear();
  EXPECT_EQ(MakeReplayDriver(rig, context, {}).error().code, ErrorCode::kBadInput);
  recording.views.front().stop.reset();
  EXPECT_EQ(MakeReplayDriver(Rig(false), context, {}).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace rigcal
