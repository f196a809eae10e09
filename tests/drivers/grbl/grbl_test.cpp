#include <fcntl.h>
#include <gmock/gmock.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <thread>

#include "drivers/grbl/grbl_driver.h"
#include "sim_fixtures/grbl/grbl_simulator.h"
#include "tests/drivers/positioner_contract.h"
#include "tests/support/fake_clock.h"

namespace rigcal {
namespace {

using sim::GrblMachine;
using sim::GrblTrouble;
using ::testing::HasSubstr;

constexpr double kPlaceStep_rad = 0.8;  ///< 46 degrees: more than a second at 30 degrees/s
constexpr double kHang_s = 60;          ///< real time beyond which a wait that should have ended hangs
constexpr double kDay_s = 86400;        ///< more than any wait of the driver

/// A machine on a pseudo-terminal. Its motion goes by a clock that passes where the driver waits for motion; answers
/// come in real time. A wait for an answer that does not come ends when the guard lets a day pass.
class GrblPeer final : public PositionerPeer {
 public:
  GrblPeer() : simulator_(*sim::GrblSimulator::Start(clock_)) {
    With([](GrblMachine& machine) { machine.SetWorkOffset({-1, 0, 0}); });  // where homing leaves it is 0
    guard_ = std::jthread([this](const std::stop_token& stop) {
      std::mutex mutex;
      std::unique_lock lock(mutex);
      std::condition_variable_any never;
      never.wait_for(lock, stop, std::chrono::duration<double>(kHang_s), [] { return false; });
      while (!stop.stop_requested())
        clock_.Advance(kDay_s), std::this_thread::sleep_for(std::chrono::milliseconds(100));
    });
  }
  ~GrblPeer() override {
    With([](GrblMachine& machine) { machine.SetReceived(nullptr); });
  }

  FakeClock& Time() override { return clock_; }
  double SlackS() const override { return 0; }
  std::stop_token StopAfter(double seconds) override { return clock_.StopAfter(seconds); }
  PositionerSettings Settings() override {
    return {.driver = "grbl",
            .address = simulator_->Path(),
            .axes = {{.name = "table", .device_letter = "X", .least = -0.5, .most = 6.3}},
            .move_timeout_s = 20};
  }
  Result<std::unique_ptr<PositionerDevice>> Open() override { return Open(Settings()); }
  Result<std::unique_ptr<PositionerDevice>> Open(const PositionerSettings& settings) {
    return (*MakeGrblDriver({}, {.clock = &clock_}, {}))->OpenPositioner(settings, {});
  }
  std::vector<double> Place(int number) override { return {(1 + number) * kPlaceStep_rad}; }
  std::vector<double> Position() override {
    double x = 0;
    With([&](GrblMachine& machine) { x = machine.PositionInWork()[0]; });
    return {x * std::numbers::pi / 180};
  }

  /// Waits for what was sent to arrive; with the line cut, lets the second pass that the machine may take.
  bool Moving() override {
    bool moving = false, cut = false;
    for (int slice = 0; slice < 300; ++slice) {
      With([&](GrblMachine& machine) { moving = machine.Moving(), cut = machine.LineCut(); });
      if (!moving || std::exchange(pushed_, false)) break;
      if (cut) clock_.Advance(1.0);
      if (!cut) std::this_thread::sleep_for(std::chrono::milliseconds(10));
      if (cut) With([&](GrblMachine& machine) { moving = machine.Moving(); });
      if (cut) break;
    }
    return moving;
  }

  std::optional<std::string> WhyNot(PositionerFault /*fault*/) override { return std::nullopt; }
  void Set(PositionerFault fault, bool on) override {
    if (fault == PositionerFault::kException) {
      clock_.After(0.3, [] { throw std::runtime_error("in the middle of a move"); });
    }
    if (fault == PositionerFault::kPushed) {
      simulator_->Push("$J=G90X3000F60\n");
      pushed_ = true;
    }
    With([&](GrblMachine& machine) {
      if (fault == PositionerFault::kHoming) machine.Faults().no_home = on;
      if (fault == PositionerFault::kStuck) machine.Faults().stuck = on;
      if (fault == PositionerFault::kOffTarget) machine.Faults().miss = on ? 0.6 : 0;  // degrees
      if (fault == PositionerFault::kAlarm) machine.Faults().in_motion = GrblTrouble::kLimitSwitch;
      if (fault == PositionerFault::kGone) machine.Faults().in_motion = GrblTrouble::kLineCut;
    });
  }

  void With(const std::function<void(GrblMachine&)>& use) { simulator_->With(use); }
  sim::GrblSimulator& Simulator() { return *simulator_; }

 private:
  FakeClock clock_;
  std::unique_ptr<sim::GrblSimulator> simulator_;
  bool pushed_ = false;
  std::jthread guard_;
};

INSTANTIATE_TEST_SUITE_P(Grbl, PositionerContract,
                         ::testing::Values([] { return std::unique_ptr<PositionerPeer>(new GrblPeer); }));

class GrblDevice : public ::testing::Test {
 protected:
  void Open(const PositionerSettings& settings) {
    auto opened = peer_.Open(settings);
    ASSERT_TRUE(opened) << opened.error().message;
    device_ = std::move(*opened);
    const Result<void> homed = device_->Home({});
    ASSERT_TRUE(homed) << homed.error().message;
  }
  void Open() { Open(peer_.Settings()); }
  Result<RecordedStop> Go(int place) { return device_->MoveTo({"stop", peer_.Place(place)}, {}); }
  void ExpectTrouble(GrblTrouble trouble, const std::string& why) {
    Open();
    peer_.With([&](GrblMachine& machine) { machine.Faults().in_motion = trouble; });
    const Result<RecordedStop> moved = Go(1);
    ASSERT_FALSE(moved);
    EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
    EXPECT_THAT(moved.error().message, HasSubstr(why));
    EXPECT_THAT(moved.error().message, HasSubstr(peer_.Simulator().Path()));
    EXPECT_THAT(moved.error().message, HasSubstr("'table'"));
    EXPECT_FALSE(peer_.Moving());
    EXPECT_LT(peer_.Position()[0], peer_.Place(1)[0] - 0.1);
  }

  GrblPeer peer_;
  std::unique_ptr<PositionerDevice> device_;
};

TEST_F(GrblDevice, ALimitSwitchStopsItAndItCanBeHomedAgain) {
  ExpectTrouble(GrblTrouble::kLimitSwitch, "ALARM:1, a limit switch was hit");
  const Result<RecordedStop> locked = Go(0);
  ASSERT_FALSE(locked);
  EXPECT_THAT(locked.error().message, HasSubstr("home it"));
  ASSERT_TRUE(device_->Home({}));
  EXPECT_TRUE(Go(0));
}

TEST_F(GrblDevice, AnOpenDoorStopsIt) {
  ExpectTrouble(GrblTrouble::kDoor, "the safety door is open");
}

TEST_F(GrblDevice, AFeedHoldOfSomebodyElseEndsTheMove) {
  ExpectTrouble(GrblTrouble::kFeedHold, "feed hold");
}

TEST(GrblTroubles, TheReasonIsToldWhicheverCommandFindsIt) {
  for (const GrblTrouble trouble : {GrblTrouble::kFeedHold, GrblTrouble::kDoor}) {
    const char* why = trouble == GrblTrouble::kDoor ? "the safety door is open" : "feed hold";
    for (const double after_s : {0.11, 0.21}) {  // found by a report, and by a jog that is refused
      GrblPeer peer;
      const auto device = std::move(*peer.Open());
      ASSERT_TRUE(device->Home({}));
      peer.With([&](GrblMachine& machine) {
        machine.Faults().in_motion = trouble;
        machine.Faults().in_motion_after_s = after_s;
      });
      const Result<RecordedStop> moved = device->MoveTo({"stop", peer.Place(1)}, {});
      ASSERT_FALSE(moved);
      EXPECT_THAT(moved.error().message, HasSubstr(why)) << after_s << " s";
    }
  }
}

TEST_F(GrblDevice, ABoardThatWasResetHasLostItsPosition) {
  ExpectTrouble(GrblTrouble::kPowerCut, "the controller was reset");
  EXPECT_FALSE(Go(0));
  ASSERT_TRUE(device_->Home({}));
  EXPECT_TRUE(Go(0));
}

TEST_F(GrblDevice, AResetBetweenTwoMovesIsNoticed) {
  Open();
  ASSERT_TRUE(Go(0));
  peer_.Simulator().Push("\x18");
  const Result<RecordedStop> moved = Go(1);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
  EXPECT_THAT(moved.error().message, HasSubstr("the controller was reset"));
  EXPECT_THAT(moved.error().message, HasSubstr("home it"));
}

TEST_F(GrblDevice, ALineThatIsCutLetsItStandWithinASecond) {
  ExpectTrouble(GrblTrouble::kLineCut, "the serial line is gone");
  const Result<RecordedStop> again = Go(0);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kDevice);
}

TEST_F(GrblDevice, SilenceIsATimeOut) {
  Open();
  peer_.With([](GrblMachine& machine) { machine.Faults().silent = true; });
  peer_.Simulator().WhenSilent([this] { peer_.Time().Advance(10); });
  const Result<RecordedStop> moved = Go(1);
  peer_.Simulator().WhenSilent({});
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(moved.error().message, HasSubstr("no answer to '?'"));
  EXPECT_FALSE(peer_.Moving());
}

TEST_F(GrblDevice, WhatDoesNotAnswerIsNotOpened) {
  peer_.With([](GrblMachine& machine) { machine.Faults().silent = true; });
  peer_.Simulator().WhenSilent([this] { peer_.Time().Advance(10); });
  const auto opened = peer_.Open();
  peer_.Simulator().WhenSilent({});
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kDevice);
  EXPECT_THAT(opened.error().message, HasSubstr("nothing that speaks GRBL"));
}

TEST_F(GrblDevice, HaltKeepsThePositionWhereItCouldStop) {
  Open();
  std::stop_token stop = peer_.StopAfter(0.5);
  ASSERT_FALSE(device_->MoveTo({"stop", peer_.Place(1)}, stop));
  EXPECT_TRUE(Go(1)) << "a feed hold loses no steps";
}

TEST_F(GrblDevice, ErrorsOfTheControllerAreTold) {
  peer_.With([](GrblMachine& machine) { machine.Settings()[20] = 1; });  // soft limits: nothing beyond machine zero
  Open();
  const Result<RecordedStop> moved = Go(0);
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().message, HasSubstr("error:15, the target is beyond the machine's travel"));
}

TEST_F(GrblDevice, WithoutLimitSwitchesZeroIsWhereItStands) {
  peer_.With([](GrblMachine& machine) {
    machine.Settings()[22] = 0;
    machine.SetWorkOffset({});
    (void)machine.PowerOn();
  });
  Open();
  EXPECT_NEAR(peer_.Position()[0], 0, 1e-9);
  EXPECT_TRUE(Go(0));
}

TEST_F(GrblDevice, RefusesAStartupBlockThatMoves) {
  peer_.With([](GrblMachine& machine) { machine.Faults().startup = 20; });
  const auto opened = peer_.Open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message, HasSubstr("the startup block $N0=G91G1X20.000F60 moves the machine"));
}

TEST_F(GrblDevice, ABoardThatMovesByItselfIsNotHomed) {
  auto opened = peer_.Open();
  ASSERT_TRUE(opened) << opened.error().message;
  peer_.With([](GrblMachine& machine) { machine.Faults().startup = 20; });
  const Result<void> homed = (*opened)->Home({});
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().code, ErrorCode::kDevice);
  EXPECT_THAT(homed.error().message, HasSubstr("state Run: somebody else moves it, or a startup block ($N0, $N1)"));
}

TEST_F(GrblDevice, WorkCoordinatesInReportsAreUsedAsTheyAre) {
  peer_.With([](GrblMachine& machine) { machine.Settings()[10] = 2; });
  Open();
  const Result<RecordedStop> stop = Go(0);
  ASSERT_TRUE(stop) << stop.error().message;
  EXPECT_NEAR(*stop->axes[0].reported, peer_.Place(0)[0], 1e-4);
}

TEST_F(GrblDevice, ApproachesAStopFromItsSideWithTheBacklash) {
  PositionerSettings settings = peer_.Settings();
  settings.axes[0].approach = 1;
  settings.axes[0].backlash = 0.2;
  Open(settings);
  ASSERT_TRUE(Go(1));
  double lowest_rad = peer_.Place(1)[0];
  for (int i = 1; i < 100; ++i) {
    peer_.Time().After(0.05 * i, [&] { lowest_rad = std::min(lowest_rad, peer_.Position()[0]); });
  }
  ASSERT_TRUE(Go(0));
  EXPECT_NEAR(lowest_rad, peer_.Place(0)[0] - 0.2, 0.03);  // seen at every 0.05 s of 30 degrees/s
  peer_.Time().Advance(10);
}

TEST_F(GrblDevice, MovesAGantryAtTheSpeedOfItsAxes) {
  PositionerSettings settings = peer_.Settings();
  settings.axes = {{.name = "x", .device_letter = "X", .unit = AxisUnit::kMetre, .speed = 0.01},
                   {.name = "z", .device_letter = "Z", .unit = AxisUnit::kMetre}};
  Open(settings);
  const double begin_s = peer_.Time().NowS();
  const Result<RecordedStop> stop = device_->MoveTo({"stop", {0.05, -0.02}}, {});
  ASSERT_TRUE(stop) << stop.error().message;
  EXPECT_NEAR(peer_.Time().NowS() - begin_s, 5, 0.5);
  EXPECT_NEAR(*stop->axes[1].reported, -0.02, 1e-6);
}

TEST_F(GrblDevice, ADeviceIsHeldByOne) {
  Open();
  const auto second = peer_.Open();
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kDevice);
  EXPECT_THAT(second.error().message, HasSubstr("another program holds it"));
  device_.reset();
  EXPECT_TRUE(peer_.Open());
}

TEST_F(GrblDevice, RefusesWhatIsNoSerialDevice) {
  PositionerSettings settings = peer_.Settings();
  settings.address = "/dev/null";
  EXPECT_EQ(peer_.Open(settings).error().code, ErrorCode::kBadInput);
  settings.address = "/dev/ttyNowhere";
  EXPECT_EQ(peer_.Open(settings).error().code, ErrorCode::kNotFound);
  settings = peer_.Settings();
  settings.axes[0].device_letter = "C";
  EXPECT_EQ(peer_.Open(settings).error().code, ErrorCode::kBadInput);
}

TEST_F(GrblDevice, RefusesAControllerThatReportsInches) {
  peer_.With([](GrblMachine& machine) { machine.Settings()[13] = 1; });
  const auto opened = peer_.Open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(opened.error().message, HasSubstr("$13=0"));
}

}  // namespace
}  // namespace rigcal
