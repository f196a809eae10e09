#include "drivers/acquire/acquire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <stdexcept>

#include "tests/drivers/scripted_devices.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kSettle_s = 0.5;
constexpr int kNumStops = 3;

/// Two cameras at a table with three stops, and what was stored.
class AcquireTest : public ::testing::Test {
 protected:
  AcquireTest() {
    right_.seed = 1000;
    for (int s = 0; s < kNumStops; ++s) {
      plan_.stops.push_back({{fmt::format("{:02}", s), {0.5 * s}}, {0, 1}});
    }
    plan_.settle_s = kSettle_s;
    store_ = [this](const TakenPicture& taken) -> Result<void> {
      const std::lock_guard lock(mutex_);
      stored_.push_back(fmt::format("{} {}", taken.camera, taken.stop.id));
      pictures_.push_back(taken.picture.pixels);
      return {};
    };
  }

  Result<AcquisitionOutcome> Run(const std::stop_token& stop = {}) {
    return Acquire({{&left_, &right_}, &table_, &clock_}, plan_, store_, listener_, stop);
  }
  /// The error of an acquisition that must fail, after which the table stands.
  Error FailureOf(const std::stop_token& stop = {}) {
    const Result<AcquisitionOutcome> outcome = Run(stop);
    EXPECT_FALSE(outcome);
    EXPECT_FALSE(table_.moving);
    EXPECT_GT(table_.num_halts, 0);
    return outcome ? Error{} : outcome.error();
  }

  FakeClock clock_;
  std::vector<std::string> log_;
  ScriptedCamera left_{"left", clock_, log_}, right_{"right", clock_, log_};
  ScriptedPositioner table_{clock_, log_};
  AcquisitionPlan plan_;
  StorePicture store_;
  std::function<void(const AcquisitionProgress&)> listener_;
  std::mutex mutex_;
  std::vector<std::string> stored_;
  std::vector<cv::Mat> pictures_;
};

TEST_F(AcquireTest, StoresEveryPictureOfEveryStop) {
  const Result<AcquisitionOutcome> outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(stored_, ElementsAre("0 00", "1 00", "0 01", "1 01", "0 02", "1 02"));
  for (int s = 0; s < kNumStops; ++s) {
    EXPECT_EQ(cv::norm(pictures_[2 * s], TexturedPicture(s), cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(pictures_[2 * s + 1], TexturedPicture(1000 + s), cv::NORM_INF), 0);
  }
  EXPECT_EQ(outcome->num_pictures, 6);
  EXPECT_EQ(outcome->num_retaken, 0);
  EXPECT_EQ(outcome->num_recovered, 0);
  EXPECT_THAT(table_.finished, ElementsAre("00 good", "01 good", "02 good"));
  EXPECT_GT(table_.num_halts, 0);
}

TEST_F(AcquireTest, FiresAllTogetherOnceTheTableHasSettled) {
  plan_.stops.resize(1);
  double settled_s = 0;
  listener_ = [&](const AcquisitionProgress& progress) {
    if (progress.phase == AcquisitionPhase::kTaking && settled_s == 0) settled_s = clock_.NowS();
  };
  ASSERT_TRUE(Run());
  EXPECT_THAT(log_, ElementsAre("home", "move 00", "ready left", "ready right", "fire left", "fire right",
                                "collect left", "collect right"));
  EXPECT_EQ(settled_s, 2 * ScriptedPositioner::kMove_s + kSettle_s);
}

TEST_F(AcquireTest, TakesOnlyWhatIsPlanned) {
  plan_.stops[0].cameras = {1};
  plan_.stops[1].cameras = {0};
  plan_.stops.resize(2);
  ASSERT_TRUE(Run());
  EXPECT_THAT(stored_, ElementsAre("1 00", "0 01"));
}

TEST_F(AcquireTest, CollectsFromAllBeforeItRestoresWhatFailed) {
  plan_.stops.resize(1);
  left_.script[0] = ShotKind::kIncomplete;
  const Result<AcquisitionOutcome> outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(log_,
              ElementsAre("home", "move 00", "ready left", "ready right", "fire left", "fire right", "collect left",
                          "collect right", "restore left", "ready left", "fire left", "collect left"));
  EXPECT_THAT(stored_, ElementsAre("1 00", "0 00"));
  EXPECT_EQ(outcome->num_retaken, 1);
}

TEST_F(AcquireTest, ACameraThatComesBackGivesAllItsPictures) {
  constexpr double kAway_s = 3;                                            // issue 4, point 3
  left_.gone_from_s = 2 * ScriptedPositioner::kMove_s + kSettle_s + 0.05;  // while it exposes
  left_.gone_until_s = left_.gone_from_s + kAway_s;
  const Result<AcquisitionOutcome> outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_EQ(stored_.size(), 6);
  EXPECT_EQ(outcome->num_recovered, 1);
}

TEST_F(AcquireTest, ACameraThatIsGoneForGoodIsNamedInTimeAndTheRestIsKept) {
  const double second_stop_s = 3 * ScriptedPositioner::kMove_s + kSettle_s;
  right_.gone_from_s = second_stop_s;
  const Error error = FailureOf();
  EXPECT_EQ(error.code, ErrorCode::kDevice);
  EXPECT_THAT(error.message, HasSubstr("stop '01': camera 'right'"));
  constexpr double kReportedWithin_s = 15;  // issue 4, point 3
  EXPECT_LE(clock_.NowS() - right_.gone_from_s, kReportedWithin_s);
  EXPECT_THAT(stored_, ElementsAre("0 00", "1 00", "0 01"));
  ASSERT_EQ(table_.finished.size(), 2);
  EXPECT_THAT(table_.finished[1], HasSubstr("camera 'right'"));
}

TEST_F(AcquireTest, TwoCamerasThatAreGoneShareTheTime) {
  left_.gone_from_s = right_.gone_from_s = 0;
  left_.gone_until_s = plan_.settings.recover_s;  // it comes back when the time is nearly over
  FailureOf();
  const double stop_s = 2 * ScriptedPositioner::kMove_s + kSettle_s;
  EXPECT_LE(clock_.NowS() - stop_s, plan_.settings.picture_s + plan_.settings.recover_s);
}

TEST_F(AcquireTest, ABadPictureIsTakenAgain) {
  for (const ShotKind kind : {ShotKind::kSaturated, ShotKind::kDark, ShotKind::kBlurred, ShotKind::kSame,
                              ShotKind::kMissing, ShotKind::kIncomplete}) {
    std::vector<std::string> log;
    ScriptedCamera camera("left", clock_, log);
    camera.script[1] = kind;
    pictures_.clear();
    plan_.stops = {{{"00", {0}}, {0}}, {{"01", {1}}, {0}}};
    const auto outcome = Acquire({{&camera}, &table_, &clock_}, plan_, store_, {}, {});
    ASSERT_TRUE(outcome) << outcome.error().message;
    EXPECT_EQ(outcome->num_retaken, 1) << static_cast<int>(kind);
    ASSERT_EQ(pictures_.size(), 2);
    EXPECT_EQ(cv::norm(pictures_[1], TexturedPicture(2), cv::NORM_INF), 0) << static_cast<int>(kind);
  }
}

TEST_F(AcquireTest, APictureThatStaysBadEndsItWithTheNumberAndTheLimit) {
  for (int shot = 2; shot < 5; ++shot) right_.script[shot] = ShotKind::kSaturated;
  const Error error = FailureOf();
  EXPECT_EQ(error.code, ErrorCode::kDevice);
  EXPECT_THAT(error.message, HasSubstr("stop '02': camera 'right': 75 % of the pixels are saturated (limit 50 %)"));
  EXPECT_THAT(error.message, HasSubstr("2 retakes"));
  EXPECT_EQ(std::ranges::count(log_, "fire right"), 5);
  EXPECT_THAT(stored_, ElementsAre("0 00", "1 00", "0 01", "1 01", "0 02"));
}

TEST_F(AcquireTest, AllPicturesOfAStopHaveOneTimeToCome) {
  left_.script[0] = right_.script[0] = ShotKind::kMissing;
  plan_.settings.retakes = 0;
  EXPECT_EQ(FailureOf().code, ErrorCode::kDevice);
  const double stop_s = 2 * ScriptedPositioner::kMove_s + kSettle_s;
  EXPECT_NEAR(clock_.NowS(), stop_s + plan_.settings.picture_s, 1e-9);
}

TEST_F(AcquireTest, StoresWhileTheTableMoves) {
  std::condition_variable changed;
  bool moving_on = false, was_moving = false;
  table_.on_move = [&](const std::string& stop) {
    const std::lock_guard lock(mutex_);
    moving_on = moving_on || stop == "01";
    changed.notify_all();
  };
  store_ = [&](const TakenPicture& taken) -> Result<void> {
    std::unique_lock lock(mutex_);
    if (taken.stop.id != "00") return {};
    was_moving = changed.wait_for(lock, std::chrono::seconds(60), [&] { return moving_on; });  // a bound for hangs
    return {};
  };
  ASSERT_TRUE(Run());
  EXPECT_TRUE(was_moving);
}

TEST_F(AcquireTest, WhatTheDiskRefusesEndsIt) {
  store_ = [&](const TakenPicture& taken) -> Result<void> {
    if (taken.stop.id == "01") return Fail(ErrorCode::kDiskFull, "out/cam: no space left");
    return {};
  };
  const Error error = FailureOf();
  EXPECT_EQ(error.code, ErrorCode::kDiskFull);
}

TEST_F(AcquireTest, AnAlarmOfTheTableEndsIt) {
  table_.failing_stop = "01";
  const Error error = FailureOf();
  EXPECT_THAT(error.message, HasSubstr("alarm on the way to '01'"));
  EXPECT_THAT(stored_, ElementsAre("0 00", "1 00"));
}

TEST_F(AcquireTest, AnExceptionLeavesTheTableHalted) {
  left_.throws_at_shot = 1;
  EXPECT_THROW((void)Run(), std::runtime_error);
  EXPECT_GT(table_.num_halts, 0);
}

TEST_F(AcquireTest, AnExceptionOfTheStoreReachesTheCaller) {
  store_ = [](const TakenPicture&) -> Result<void> { throw std::runtime_error("a bug in the store"); };
  EXPECT_THROW((void)Run(), std::runtime_error);
  EXPECT_GT(table_.num_halts, 0);
}

TEST_F(AcquireTest, CanBeCancelledAtAnyPoint) {
  left_.script[1] = ShotKind::kMissing;  // one stop waits for a picture, and brings a camera back
  right_.gone_from_s = 5;
  right_.gone_until_s = 8;
  ASSERT_TRUE(Run()) << "the same acquisition ends by itself when nobody stops it";
  const double whole_s = clock_.NowS();
  int num_cancelled = 0;
  for (double after_s = 0; after_s < whole_s; after_s += 0.11) {
    FakeClock clock;
    std::vector<std::string> log;
    ScriptedCamera left("left", clock, log), right("right", clock, log);
    ScriptedPositioner table(clock, log);
    left.script[1] = ShotKind::kMissing;
    right.gone_from_s = 5;
    right.gone_until_s = 8;
    const std::stop_token stop = clock.StopAfter(after_s);
    const auto outcome = Acquire({{&left, &right}, &table, &clock}, plan_, store_, {}, stop);
    ASSERT_FALSE(outcome) << after_s;
    EXPECT_EQ(outcome.error().code, ErrorCode::kCancelled) << after_s << " " << outcome.error().message;
    EXPECT_LE(clock.NowS(), after_s + 1) << after_s;
    EXPECT_FALSE(table.moving) << after_s;
    EXPECT_GT(table.num_halts, 0) << after_s;
    ++num_cancelled;
  }
  EXPECT_GT(num_cancelled, 50);
}

TEST_F(AcquireTest, TellsHowTheTimeWasSpent) {
  constexpr double kDisk_s = 7;
  std::condition_variable changed;
  bool all_taken = false;
  listener_ = [&](const AcquisitionProgress& progress) {
    const std::lock_guard lock(mutex_);
    all_taken = progress.phase == AcquisitionPhase::kStoring && table_.finished.size() == kNumStops;
    changed.notify_all();
  };
  store_ = [&](const TakenPicture& taken) -> Result<void> {
    if (taken.stop.id != "02" || taken.camera != 1) return {};
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed.wait_for(lock, std::chrono::seconds(60), [&] { return all_taken; }));  // a bound for hangs
    clock_.Advance(kDisk_s);
    return {};
  };
  const Result<AcquisitionOutcome> outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_NEAR(outcome->times.moving_s, (kNumStops + 1) * ScriptedPositioner::kMove_s, 1e-9);
  EXPECT_NEAR(outcome->times.settling_s, kNumStops * kSettle_s, 1e-9);
  EXPECT_NEAR(outcome->times.taking_s, kNumStops * ScriptedCamera::kExposure_s, 1e-9);
  EXPECT_NEAR(outcome->times.storing_s, kDisk_s, 1e-9);
}

TEST_F(AcquireTest, NotesWhenAPictureWasFired) {
  plan_.utc_now = [&] { return fmt::format("at {:.1f} s", clock_.NowS()); };
  std::vector<std::string> times;
  store_ = [&](const TakenPicture& taken) -> Result<void> {
    times.push_back(taken.picture.taken_at.value_or("none"));
    return {};
  };
  plan_.stops.resize(1);
  ASSERT_TRUE(Run());
  EXPECT_THAT(times, ElementsAre("at 2.5 s", "at 2.5 s"));
}

TEST_F(AcquireTest, APositionerThatSomebodyElseMovesSaysItsStopsItself) {
  plan_.stops.clear();
  plan_.cameras_at = [](const RecordedStop& reached) -> Result<std::vector<int>> {
    if (reached.id == "over") return std::vector<int>{};
    return reached.id == "b" ? std::vector{1} : std::vector{0, 1};
  };
  table_.told = {{.id = "a"}, {.id = "over"}, {.id = "b"}};
  std::vector<int> stops;
  listener_ = [&](const AcquisitionProgress& progress) {
    EXPECT_FALSE(progress.num_stops);
    if (progress.phase == AcquisitionPhase::kStoring) stops.push_back(progress.stop);
  };
  const auto outcome = Run();
  ASSERT_TRUE(outcome) << outcome.error().message;
  EXPECT_THAT(stored_, ElementsAre("0 a", "1 a", "1 b"));
  EXPECT_THAT(table_.finished, ElementsAre("a good", "over good", "b good"));
  EXPECT_EQ(stops.back(), 3) << "where it was asked for one stop more";
  EXPECT_GT(table_.num_halts, 0);
}

TEST_F(AcquireTest, WhoMovesThePositionerIsToldWhyAStopIsNotTaken) {
  plan_.stops.clear();
  plan_.cameras_at = [](const RecordedStop& reached) -> Result<std::vector<int>> {
    if (reached.id == "a") return std::vector{0, 1};
    return Fail(ErrorCode::kDiskFull, "no room for '{}'", reached.id);
  };
  table_.told = {{.id = "a"}, {.id = "b"}, {.id = "c"}};
  EXPECT_EQ(FailureOf().code, ErrorCode::kDiskFull);
  EXPECT_THAT(table_.finished, ElementsAre("a good", "b no room for 'b'"));
  EXPECT_THAT(stored_, ElementsAre("0 a", "1 a"));
}

TEST_F(AcquireTest, APositionerThatGoesWhereItIsToldHasNoStopsOfItsOwn) {
  class Told final : public PositionerDevice {
    Result<void> Home(const std::stop_token& /*stop*/) override { return {}; }
    Result<RecordedStop> MoveTo(const StopTarget& /*target*/, const std::stop_token& /*stop*/) override { return {}; }
    Result<void> FinishStop(const Result<void>& /*taken*/) override { return {}; }
    void Halt() noexcept override {}
  } told;
  plan_.stops.clear();
  plan_.cameras_at = [](const RecordedStop&) -> Result<std::vector<int>> { return std::vector{0}; };
  const auto outcome = Acquire({{&left_, &right_}, &told, &clock_}, plan_, store_, {}, {});
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().code, ErrorCode::kUnsupported);
}

TEST_F(AcquireTest, WithoutAPositionerThereIsOneStop) {
  plan_.stops.resize(1);
  const auto outcome = Acquire({{&left_, &right_}, nullptr, &clock_}, plan_, store_, {}, {});
  ASSERT_TRUE(outcome);
  EXPECT_THAT(stored_, ElementsAre("0 00", "1 00"));
}

}  // namespace
}  // namespace rigcal
