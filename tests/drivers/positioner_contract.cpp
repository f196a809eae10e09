#include "tests/drivers/positioner_contract.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace rigcal {

using ::testing::HasSubstr;

namespace {

constexpr double kInMove_s = 0.5;  ///< from the begin of a move: it is under way then

template <typename T>
std::string MessageOf(const Result<T>& result) {
  return result ? "no error" : result.error().message;
}

double ToleranceOf(const PositionerSettings& settings, const AxisSettings& axis) {
  return axis.unit == AxisUnit::kRadian ? settings.position_tolerance_rad : settings.position_tolerance_m;
}

}  // namespace

#define SKIP_WITHOUT(fault) \
  if (const auto why = peer_->WhyNot(fault)) GTEST_SKIP() << *why

std::unique_ptr<PositionerDevice> PositionerContract::OpenHomed() {
  Result<std::unique_ptr<PositionerDevice>> positioner = peer_->Open();
  EXPECT_TRUE(positioner) << MessageOf(positioner);
  if (!positioner) return nullptr;
  const Result<void> homed = (*positioner)->Home({});
  EXPECT_TRUE(homed) << MessageOf(homed);
  return std::move(*positioner);
}

Result<RecordedStop> PositionerContract::Go(PositionerDevice& positioner, int place, const std::stop_token& stop) {
  return positioner.MoveTo({fmt::format("{:02}", place), peer_->Place(place)}, stop);
}

bool PositionerContract::Near(const std::vector<double>& a, const std::vector<double>& b) const {
  const PositionerSettings settings = peer_->Settings();
  if (a.size() != settings.axes.size() || b.size() != a.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(std::abs(a[i] - b[i]) <= ToleranceOf(settings, settings.axes[i]))) return false;
  }
  return true;
}

void PositionerContract::ExpectFailedMove(PositionerDevice& positioner, ErrorCode code) {
  const Result<RecordedStop> moved = Go(positioner, 1);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, code) << MessageOf(moved);
  EXPECT_THAT(moved.error().message, HasSubstr(peer_->Settings().driver));
  EXPECT_FALSE(peer_->Moving());
}

TEST_P(PositionerContract, Homes) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  EXPECT_FALSE(peer_->Moving());
}

TEST_P(PositionerContract, GoesWhereToldAndReportsIt) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  for (int place = 0; place < 3; ++place) {
    const Result<RecordedStop> stop = Go(*positioner, place);
    ASSERT_TRUE(stop) << MessageOf(stop);
    EXPECT_FALSE(peer_->Moving());
    EXPECT_TRUE(Near(peer_->Position(), peer_->Place(place)));
    EXPECT_EQ(stop->id, fmt::format("{:02}", place));
    const std::vector<AxisSettings> axes = peer_->Settings().axes;
    ASSERT_EQ(stop->axes.size(), axes.size());
    for (std::size_t i = 0; i < axes.size(); ++i) {
      EXPECT_EQ(stop->axes[i].axis, axes[i].name);
      EXPECT_EQ(stop->axes[i].unit, axes[i].unit);
      EXPECT_EQ(stop->axes[i].commanded, peer_->Place(place)[i]);
      if (stop->axes[i].reported) {
        EXPECT_NEAR(*stop->axes[i].reported, peer_->Position()[i], ToleranceOf(peer_->Settings(), axes[i]));
      }
    }
    EXPECT_TRUE(positioner->FinishStop({}));
  }
}

TEST_P(PositionerContract, AStopThatFailedIsFinishedToo) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  EXPECT_TRUE(positioner->FinishStop(Fail(ErrorCode::kDevice, "camera 'left' is gone")));
  EXPECT_TRUE(Go(*positioner, 1));
}

TEST_P(PositionerContract, RefusesATargetOutsideItsLimitsBeforeItMoves) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  const std::vector<AxisSettings> axes = peer_->Settings().axes;
  int tried = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    for (const auto& [limit, beyond] : {std::pair(axes[i].least, -1.0), std::pair(axes[i].most, 1.0)}) {
      if (!limit) continue;
      std::vector<double> target = peer_->Place(1);
      target[i] = *limit + 0.01 * beyond;
      const Result<RecordedStop> moved = positioner->MoveTo({"out", target}, {});
      ASSERT_FALSE(moved);
      EXPECT_EQ(moved.error().code, ErrorCode::kBadInput) << MessageOf(moved);
      EXPECT_THAT(moved.error().message, HasSubstr(axes[i].name));
      EXPECT_TRUE(Near(peer_->Position(), peer_->Place(0)));
      ++tried;
    }
  }
  EXPECT_GT(tried, 0) << "the peer's settings must have a soft limit to show anything";
}

TEST_P(PositionerContract, RefusesATargetThatIsNone) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  std::vector<double> too_many = peer_->Place(1), no_number = peer_->Place(1);
  too_many.push_back(0);
  no_number[0] = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<double>& target : {too_many, no_number}) {
    const Result<RecordedStop> moved = positioner->MoveTo({"none", target}, {});
    ASSERT_FALSE(moved);
    EXPECT_EQ(moved.error().code, ErrorCode::kBadInput) << MessageOf(moved);
    EXPECT_TRUE(Near(peer_->Position(), peer_->Place(0)));
  }
}

TEST_P(PositionerContract, AStopTokenHaltsIt) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  const double begin_s = peer_->Time().NowS();
  const Result<RecordedStop> moved = Go(*positioner, 1, peer_->StopAfter(kInMove_s));
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kCancelled) << MessageOf(moved);
  EXPECT_FALSE(peer_->Moving());
  EXPECT_FALSE(Near(peer_->Position(), peer_->Place(1)));
  EXPECT_LE(peer_->Time().NowS() - begin_s, kInMove_s + 1 + peer_->SlackS());
}

TEST_P(PositionerContract, AStopTokenThatIsSetMovesNothing) {
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  std::stop_source stop;
  stop.request_stop();
  const Result<RecordedStop> moved = Go(*positioner, 1, stop.get_token());
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(Near(peer_->Position(), peer_->Place(0)));
}

TEST_P(PositionerContract, HomingThatFailsIsReportedAtRest) {
  SKIP_WITHOUT(PositionerFault::kHoming);
  Result<std::unique_ptr<PositionerDevice>> positioner = peer_->Open();
  ASSERT_TRUE(positioner) << MessageOf(positioner);
  peer_->Set(PositionerFault::kHoming, true);
  const Result<void> homed = (*positioner)->Home({});
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().code, ErrorCode::kDevice) << MessageOf(homed);
  EXPECT_FALSE(peer_->Moving());
}

TEST_P(PositionerContract, AnAlarmInAMoveLeavesItStopped) {
  SKIP_WITHOUT(PositionerFault::kAlarm);
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  peer_->Set(PositionerFault::kAlarm, true);
  ExpectFailedMove(*positioner, ErrorCode::kDevice);
}

TEST_P(PositionerContract, ALostConnectionLeavesItStopped) {
  SKIP_WITHOUT(PositionerFault::kGone);
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  peer_->Set(PositionerFault::kGone, true);
  ExpectFailedMove(*positioner, ErrorCode::kDevice);
}

TEST_P(PositionerContract, AMoveThatGetsNowhereEndsInTime) {
  SKIP_WITHOUT(PositionerFault::kStuck);
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  peer_->Set(PositionerFault::kStuck, true);
  const double begin_s = peer_->Time().NowS();
  ExpectFailedMove(*positioner, ErrorCode::kTimeout);
  EXPECT_LE(peer_->Time().NowS() - begin_s, peer_->Settings().move_timeout_s + 1 + peer_->SlackS());
}

TEST_P(PositionerContract, AMoveThatEndsElsewhereHasFailed) {
  SKIP_WITHOUT(PositionerFault::kOffTarget);
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  peer_->Set(PositionerFault::kOffTarget, true);
  ExpectFailedMove(*positioner, ErrorCode::kDevice);
}

TEST_P(PositionerContract, AnExceptionLeavesItStopped) {
  SKIP_WITHOUT(PositionerFault::kException);
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  ASSERT_TRUE(Go(*positioner, 0));
  peer_->Set(PositionerFault::kException, true);
  EXPECT_ANY_THROW((void)Go(*positioner, 1));
  EXPECT_FALSE(peer_->Moving());
  EXPECT_FALSE(Near(peer_->Position(), peer_->Place(1)));
}

TEST_P(PositionerContract, HaltStopsIt) {
  SKIP_WITHOUT(PositionerFault::kPushed);
  const auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  peer_->Set(PositionerFault::kPushed, true);
  ASSERT_TRUE(peer_->Moving());
  positioner->Halt();
  EXPECT_FALSE(peer_->Moving());
  positioner->Halt();  // safe at any time
}

TEST_P(PositionerContract, DestructionStopsIt) {
  SKIP_WITHOUT(PositionerFault::kPushed);
  auto positioner = OpenHomed();
  ASSERT_TRUE(positioner);
  peer_->Set(PositionerFault::kPushed, true);
  ASSERT_TRUE(peer_->Moving());
  positioner.reset();
  EXPECT_FALSE(peer_->Moving());
}

}  // namespace rigcal
