#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>

#include "drivers/linuxcnc/mdi_move.h"
#include "tests/drivers/linuxcnc/linuxcnc_peer.h"

namespace rigcal {
namespace {

using sim::LinuxcncMachine;
using sim::LinuxcncTrouble;
using sim::RshWire;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDeg = std::numbers::pi / 180;

INSTANTIATE_TEST_SUITE_P(Linuxcnc, PositionerContract,
                         ::testing::Values([] { return std::unique_ptr<PositionerPeer>(new LinuxcncPeer); }));

class LinuxcncDevice : public ::testing::Test {
 protected:
  ~LinuxcncDevice() override {
    peer_.With([](LinuxcncMachine& machine) { machine.SetReceived(nullptr); });
    peer_.Simulator().WhenSilent({});
  }
  void Open(const PositionerSettings& settings) {
    auto opened = peer_.Open(settings);
    ASSERT_TRUE(opened) << opened.error().message;
    device_ = std::move(*opened);
    const Result<void> homed = device_->Home({});
    ASSERT_TRUE(homed) << homed.error().message;
  }
  void Open() { Open(peer_.Settings()); }
  Result<RecordedStop> Go(int place) { return device_->MoveTo({"stop", peer_.Place(place)}, {}); }
  std::string HomingFails() {
    auto opened = peer_.Open();
    EXPECT_TRUE(opened);
    const Result<void> homed = (*opened)->Home({});
    return homed ? "no error" : homed.error().message;
  }
  void ExpectTrouble(LinuxcncTrouble trouble, const std::string& why) {
    Open();
    peer_.With([&](LinuxcncMachine& machine) { machine.Faults().in_motion = trouble; });
    const Result<RecordedStop> moved = Go(1);
    ASSERT_FALSE(moved);
    EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
    EXPECT_THAT(moved.error().message,
                AllOf(HasSubstr(why), HasSubstr(peer_.Simulator().Address()), HasSubstr("'table'")));
    EXPECT_FALSE(peer_.Moving());
    EXPECT_LT(peer_.Position()[0], peer_.Place(1)[0] - 0.1);
  }

  LinuxcncPeer peer_;
  std::unique_ptr<PositionerDevice> device_;
};

TEST_F(LinuxcncDevice, AnEmergencyStopEndsTheMoveAndIsNotReset) {
  ExpectTrouble(LinuxcncTrouble::kEmergencyStop, "the emergency stop is on");
  EXPECT_FALSE(Go(0));
  peer_.With([](LinuxcncMachine& machine) { machine.SetEmergencyStop(true, false); });  // released, not reset
  const Result<void> homed = device_->Home({});
  ASSERT_FALSE(homed);
  EXPECT_THAT(homed.error().message, HasSubstr("set estop off"));
  peer_.With([](LinuxcncMachine& machine) { machine.SetEmergencyStop(false, false); });
  ASSERT_TRUE(device_->Home({}));
  EXPECT_TRUE(Go(0));
}

TEST_F(LinuxcncDevice, ALimitSwitchEndsTheMoveAndNamesTheJoint) {
  ExpectTrouble(LinuxcncTrouble::kLimit,
                "its power is off; joint 2 on limit switch error; joint 2: MAXHARD (axis 'table')");
  const Result<void> homed = device_->Home({});  // it is still there
  ASSERT_FALSE(homed);
  EXPECT_THAT(homed.error().message, HasSubstr("joint 2 on limit switch error"));
}

TEST_F(LinuxcncDevice, PowerThatGoesOffEndsTheMoveAndComesBackWithHoming) {
  ExpectTrouble(LinuxcncTrouble::kPowerOff, "its power is off");
  const Result<RecordedStop> off = Go(0);
  ASSERT_FALSE(off);
  EXPECT_THAT(off.error().message, HasSubstr("its power is off"));
  ASSERT_TRUE(device_->Home({}));
  EXPECT_TRUE(Go(0));
}

TEST_F(LinuxcncDevice, APauseOfSomebodyElseEndsTheMove) {
  ExpectTrouble(LinuxcncTrouble::kPause, "somebody paused it");
}

TEST_F(LinuxcncDevice, AnotherProgramThatTakesControlEndsTheMoves) {
  Open();
  ASSERT_TRUE(Go(0));
  peer_.Simulator().Push("get mode");
  const Result<RecordedStop> moved = Go(1);
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().message, HasSubstr("another program has taken control"));
  EXPECT_FALSE(peer_.Moving());
}

TEST_F(LinuxcncDevice, ALostConnectionIsMadeAgainToStopIt) {
  ExpectTrouble(LinuxcncTrouble::kCut, "the connection is lost (axis 'table')");
  ASSERT_TRUE(device_->Home({}));
  EXPECT_TRUE(Go(0));
}

TEST_F(LinuxcncDevice, WhatCannotBeStoppedIsSaid) {
  Open();
  peer_.With([&](LinuxcncMachine& machine) { machine.Faults().in_motion = LinuxcncTrouble::kGone; });
  const Result<RecordedStop> moved = Go(1);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
  EXPECT_THAT(moved.error().message, HasSubstr("it was not seen to stop: a move under way goes on to its target"));
  EXPECT_FALSE(Go(0));
  const Result<void> homed = device_->Home({});
  ASSERT_FALSE(homed);
  EXPECT_THAT(homed.error().message, HasSubstr("cannot be connected to"));
}

TEST_F(LinuxcncDevice, SilenceIsATimeOut) {
  Open();
  peer_.With([](LinuxcncMachine& machine) { machine.Faults().silent = true; });
  peer_.Simulator().WhenSilent([this] { peer_.Time().Advance(10); });
  const Result<RecordedStop> moved = Go(1);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(moved.error().message, HasSubstr("no answer"));
  EXPECT_FALSE(peer_.Moving());
}

TEST_F(LinuxcncDevice, WhatDoesNotAnswerIsNotOpened) {
  peer_.With([](LinuxcncMachine& machine) { machine.Faults().silent = true; });
  peer_.Simulator().WhenSilent([this] { peer_.Time().Advance(10); });
  const auto opened = peer_.Open();
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kDevice);
  EXPECT_THAT(opened.error().message, HasSubstr("nothing that speaks as linuxcncrsh"));
}

TEST_F(LinuxcncDevice, ARefusedCommandIsTold) {
  Open();
  peer_.With([](LinuxcncMachine& machine) { machine.Faults().refused = "MDI"; });
  const Result<RecordedStop> moved = Go(1);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
  EXPECT_THAT(moved.error().message, AllOf(HasSubstr("refuses 'set mdi"), Not(HasSubstr("another program"))));
}

TEST_F(LinuxcncDevice, ItsOwnLimitsAreTold) {
  PositionerSettings settings = peer_.Settings();
  settings.axes = {{.name = "z", .device_letter = "Z", .unit = AxisUnit::kMetre}};
  Open(settings);
  const Result<RecordedStop> moved = device_->MoveTo({"low", {-0.05}}, {});
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
  EXPECT_THAT(moved.error().message, HasSubstr("would exceed Z's negative limit (axis 'z')"));
}

TEST_F(LinuxcncDevice, AnswersInPiecesOrBehindOtherLinesAreUnderstood) {
  for (const RshWire wire : {RshWire::kByteByByte, RshWire::kMerged}) {
    peer_.Simulator().SetWire(wire);
    Open();
    const Result<RecordedStop> stop = Go(0);
    ASSERT_TRUE(stop) << stop.error().message;
    EXPECT_NEAR(*stop->axes[0].reported, peer_.Place(0)[0], 1e-6);
    ASSERT_TRUE(Go(1));
    device_.reset();
  }
}

TEST_F(LinuxcncDevice, AHomedMachineIsNotHomedAgain) {
  Open();
  ASSERT_TRUE(Go(0));
  device_.reset();
  std::vector<std::string> received;
  peer_.With([&](LinuxcncMachine& machine) { machine.SetReceived(&received); });
  Open();
  EXPECT_EQ(std::ranges::count(received, "set home -1"), 0);
  EXPECT_NEAR(peer_.Position()[0], peer_.Place(0)[0], 1e-6);
}

TEST_F(LinuxcncDevice, HomingThatLeavesAJointOutIsTold) {
  peer_.With([](LinuxcncMachine& machine) { machine.Faults().no_sequence = true; });
  EXPECT_THAT(HomingFails(), HasSubstr("HOME_SEQUENCE"));
}

TEST_F(LinuxcncDevice, HomingCanBeStopped) {
  auto opened = peer_.Open();
  ASSERT_TRUE(opened);
  const Result<void> homed = (*opened)->Home(peer_.StopAfter(0.3));
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().code, ErrorCode::kCancelled);
  EXPECT_FALSE(peer_.Moving());
}

TEST_F(LinuxcncDevice, DrivesThatDoNotComeUpAreTold) {
  peer_.With([](LinuxcncMachine& machine) { machine.Faults().no_power = true; });
  EXPECT_THAT(HomingFails(), HasSubstr("its power is off"));
}

TEST_F(LinuxcncDevice, AMachineThatSomebodyMovedIsNotTrusted) {
  Open();
  ASSERT_TRUE(Go(0));
  peer_.With([](LinuxcncMachine& machine) { machine.SetPosition('C', 10); });
  const Result<RecordedStop> moved = Go(1);
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().message, HasSubstr("moved by somebody"));
}

TEST_F(LinuxcncDevice, ApproachesAStopFromItsSideWithTheBacklash) {
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

TEST_F(LinuxcncDevice, MovesAGantryAtTheSpeedOfItsAxesWhateverTheMachinesUnit) {
  peer_.With([](LinuxcncMachine& machine) { machine.SetInches(); });
  PositionerSettings settings = peer_.Settings();
  settings.axes = {{.name = "x", .device_letter = "X", .unit = AxisUnit::kMetre, .speed = 0.01},
                   {.name = "z", .device_letter = "Z", .unit = AxisUnit::kMetre}};
  Open(settings);
  const double begin_s = peer_.Time().NowS();
  const Result<RecordedStop> stop = device_->MoveTo({"stop", {0.05, 0.02}}, {});
  ASSERT_TRUE(stop) << stop.error().message;
  EXPECT_NEAR(peer_.Time().NowS() - begin_s, 5, 0.2);
  EXPECT_NEAR(*stop->axes[0].reported, 0.05, 1e-6);
  peer_.With([](LinuxcncMachine& machine) { EXPECT_NEAR(machine.Position('Z'), 20, 1e-6); });
}

TEST_F(LinuxcncDevice, RefusesAxesAndAddressesThatCannotBe) {
  PositionerSettings settings = peer_.Settings();
  for (const char* letter : {"X", "U", ""}) {
    settings.axes[0].device_letter = letter;
    EXPECT_EQ(peer_.Open(settings).error().code, ErrorCode::kBadInput);
  }
  settings = peer_.Settings();
  settings.axes.push_back(settings.axes[0]);
  EXPECT_EQ(peer_.Open(settings).error().code, ErrorCode::kBadInput);
  for (const char* address : {"127.0.0.1", "machine.example:5007"}) {
    settings = peer_.Settings();
    settings.address = address;
    EXPECT_EQ(peer_.Open(settings).error().code, ErrorCode::kBadInput);
  }
}

TEST(MdiMove, KeepsTheSlowestAxisAtItsSpeed) {
  const AxisSettings c{.name = "table", .device_letter = "C", .speed = 10 * kDeg};
  EXPECT_EQ(MdiMove({}, {30 * kDeg}, {c}), "G21 G90 G94 G53 G1 C30.000000 F600.000000");
  const AxisSettings x{.name = "x", .device_letter = "X", .unit = AxisUnit::kMetre, .speed = 0.01};
  const AxisSettings z{.name = "z", .device_letter = "Z", .unit = AxisUnit::kMetre, .speed = 0.1};
  // 30 mm in 3 s, 40 mm in 0.4 s: 50 mm in 3 s.
  EXPECT_EQ(MdiMove({}, {0.03, 0.04}, {x, z}), "G21 G90 G94 G53 G1 X30.000000 Z40.000000 F1000.000000");
  // F counts along X alone: 10 mm while C needs 9 s.
  EXPECT_EQ(MdiMove({}, {0.01, 90 * kDeg}, {x, c}), "G21 G90 G94 G53 G1 X10.000000 C90.000000 F66.666667");
}

TEST(MdiMove, GoesAtTheControllersSpeedWithoutOne) {
  const AxisSettings c{.name = "table", .device_letter = "C"};
  EXPECT_EQ(MdiMove({}, {30 * kDeg}, {c}), "G21 G90 G94 G53 G0 C30.000000");
  const AxisSettings slow{.name = "table", .device_letter = "C", .speed = 1};
  EXPECT_EQ(MdiMove({0, 0, 0, 0, 0, 30}, {30 * kDeg}, {slow}), "G21 G90 G94 G53 G0 C30.000000");
}

}  // namespace
}  // namespace rigcal
