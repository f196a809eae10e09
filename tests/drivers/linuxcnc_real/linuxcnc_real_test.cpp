#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "drivers/linuxcnc/linuxcnc_driver.h"
#include "tests/drivers/linuxcnc_real/linuxcnc_process.h"
#include "tests/drivers/linuxcnc_real/tcp_relay.h"
#include "tests/drivers/positioner_contract.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kPlaceStep_rad = 0.8, kSpeed_rad_s = std::numbers::pi / 6;
constexpr double kHang_s = 30;
constexpr double kInMotion_s = 0.5;
constexpr const char* kLimitPin = "joint.2.pos-lim-sw-in";
constexpr const char* kChainPin = "iocontrol.0.emc-enable-in";
constexpr const char* kInhibitPin = "motion.feed-inhibit";

/// One for all tests: it starts slowly.
LinuxcncProcess* TheProcess() {
  static const Result<std::unique_ptr<LinuxcncProcess>> started = LinuxcncProcess::Start();
  if (!started) {
    std::printf("%s\n", started.error().message.c_str());
    return nullptr;
  }
  return started->get();
}

/// The machine's clock, with things that happen while somebody waits by it.
class RealClock final : public Clock {
 public:
  [[nodiscard]] double NowS() const override { return system_.NowS(); }
  bool Wait(double seconds, const std::stop_token& stop) override {
    if (event_ && NowS() >= event_at_s_) std::exchange(event_, {})();
    return system_.Wait(seconds, stop);
  }
  void After(double seconds, std::function<void()> event) {
    event_at_s_ = NowS() + seconds;
    event_ = std::move(event);
  }

 private:
  SystemClock system_;
  double event_at_s_ = 0;
  std::function<void()> event_;
};

/// Debian's LinuxCNC as the peer, through a relay that can be cut.
class RealPeer final : public PositionerPeer {
 public:
  explicit RealPeer(LinuxcncProcess& process) : process_(process), relay_(process.Port()) {
    process_.SetPin(kChainPin, true);
    process_.SetPin(kLimitPin, false);
    process_.SetPin(kInhibitPin, false);
    const double end_s = clock_.NowS() + kHang_s;
    while (process_.Say("get estop") != "ESTOP OFF" && clock_.NowS() < end_s) (void)process_.Say("set estop off");
  }
  ~RealPeer() override { process_.SetPin(kInhibitPin, false); }

  RealClock& Time() override { return clock_; }
  double SlackS() const override { return 2; }
  std::stop_token StopAfter(double seconds) override {
    std::stop_source source;
    clock_.After(seconds, [source]() mutable { source.request_stop(); });
    return source.get_token();
  }
  PositionerSettings Settings() override {
    return {.driver = "linuxcnc",
            .address = relay_.Address(),
            .axes = {{.name = "table", .device_letter = "C", .least = -0.5, .most = 6.3, .speed = kSpeed_rad_s}},
            .move_timeout_s = 10};
  }
  Result<std::unique_ptr<PositionerDevice>> Open() override {
    return (*MakeLinuxcncDriver({}, {.clock = &clock_}, {}))->OpenPositioner(Settings(), {});
  }
  std::vector<double> Place(int number) override { return {(1 + number) * kPlaceStep_rad}; }
  std::vector<double> Position() override {
    std::array<double, 6> at{};
    const std::string text = process_.Say("get abs_act_pos");
    const int count = std::sscanf(text.c_str(), "ABS_ACT_POS %lf %lf %lf %lf %lf %lf", &at[0], &at[1], &at[2], &at[3],
                                  &at[4], &at[5]);
    EXPECT_EQ(count, 6) << text;
    return {at[5] * std::numbers::pi / 180};
  }
  bool Moving() override {
    const std::vector<double> before = Position();
    clock_.Wait(0.1, {});
    return before != Position();
  }

  std::optional<std::string> WhyNot(PositionerFault fault) override {
    if (fault == PositionerFault::kHoming) return "this machine has no home switches that could be missed";
    if (fault == PositionerFault::kOffTarget) return "LinuxCNC itself ends a move with a following error then";
    return std::nullopt;
  }
  void Set(PositionerFault fault, bool on) override {
    if (fault == PositionerFault::kAlarm) clock_.After(kInMotion_s, [this] { process_.SetPin(kLimitPin, true); });
    if (fault == PositionerFault::kGone) clock_.After(kInMotion_s, [this] { relay_.Cut(); });
    if (fault == PositionerFault::kStuck) process_.SetPin(kInhibitPin, on);
    if (fault == PositionerFault::kException) clock_.After(kInMotion_s, [] { throw std::runtime_error("in a move"); });
    if (fault == PositionerFault::kPushed) {
      (void)process_.Say("set mdi G53 G1 C3000 F600");
      const double end_s = clock_.NowS() + kHang_s;
      while (!Moving() && clock_.NowS() < end_s) continue;
    }
  }

  LinuxcncProcess& Process() { return process_; }

 private:
  LinuxcncProcess& process_;
  RealClock clock_;
  TcpRelay relay_;
};

std::unique_ptr<PositionerPeer> MakePeer() {
  return std::unique_ptr<PositionerPeer>(new RealPeer(*TheProcess()));
}

class LinuxcncIsThere : public ::testing::Environment {
 public:
  void SetUp() override {
    if (TheProcess() == nullptr) GTEST_SKIP();
  }
};
const ::testing::Environment* const kEnvironment = ::testing::AddGlobalTestEnvironment(new LinuxcncIsThere);

INSTANTIATE_TEST_SUITE_P(RealLinuxcnc, PositionerContract, ::testing::Values(MakePeer));

class RealLinuxcnc : public ::testing::Test {
 protected:
  void SetUp() override {
    peer_ = std::make_unique<RealPeer>(*TheProcess());
    auto opened = peer_->Open();
    ASSERT_TRUE(opened) << opened.error().message;
    device_ = std::move(*opened);
    const Result<void> homed = device_->Home({});
    ASSERT_TRUE(homed) << homed.error().message;
    ASSERT_TRUE(device_->MoveTo({"begin", peer_->Place(0)}, {}));
  }
  /// A move in which `trouble` happens fails with `why`, at rest before its target.
  void ExpectTrouble(const std::function<void()>& trouble, const std::string& why) {
    peer_->Time().After(kInMotion_s, trouble);
    const Result<RecordedStop> moved = device_->MoveTo({"stop", peer_->Place(3)}, {});
    ASSERT_FALSE(moved);
    std::printf("  %s\n", moved.error().message.c_str());
    EXPECT_EQ(moved.error().code, ErrorCode::kDevice);
    EXPECT_THAT(moved.error().message, AllOf(HasSubstr(why), HasSubstr("'table'")));
    EXPECT_FALSE(peer_->Moving());
    EXPECT_LT(peer_->Position()[0], peer_->Place(3)[0] - 0.1);
    EXPECT_GT(peer_->Position()[0], peer_->Place(0)[0] + 0.05);
  }

  std::unique_ptr<RealPeer> peer_;
  std::unique_ptr<PositionerDevice> device_;
};

TEST_F(RealLinuxcnc, AnEmergencyStopEndsTheMove) {
  ExpectTrouble([&] { peer_->Process().SetPin(kChainPin, false); }, "the emergency stop is on");
  EXPECT_FALSE(device_->Home({}));
}

TEST_F(RealLinuxcnc, ALimitSwitchEndsTheMove) {
  ExpectTrouble([&] { peer_->Process().SetPin(kLimitPin, true); }, "joint 2 on limit switch error");
}

TEST_F(RealLinuxcnc, PowerThatGoesOffEndsTheMove) {
  ExpectTrouble([&] { (void)peer_->Process().Say("set machine off"); }, "its power is off");
  ASSERT_TRUE(device_->Home({}));
  EXPECT_TRUE(device_->MoveTo({"again", peer_->Place(0)}, {}));
}

TEST_F(RealLinuxcnc, ADriveFaultEndsTheMove) {
  ExpectTrouble([&] { peer_->Process().SetPin("joint.2.amp-fault-in", true); }, "joint 2 amplifier fault");
  peer_->Process().SetPin("joint.2.amp-fault-in", false);
}

TEST_F(RealLinuxcnc, APauseOfSomebodyElseEndsTheMove) {
  ExpectTrouble([&] { (void)peer_->Process().Say("set pause"); }, "somebody paused it");
  EXPECT_TRUE(device_->MoveTo({"again", peer_->Place(0)}, {}));
}

TEST_F(RealLinuxcnc, SettlesOnTargetFromItsSideWithTheBacklash) {
  device_.reset();
  PositionerSettings settings = peer_->Settings();
  settings.axes[0].approach = 1;
  settings.axes[0].backlash = 0.2;
  device_ = *(*MakeLinuxcncDriver({}, {.clock = &peer_->Time()}, {}))->OpenPositioner(settings, {});
  for (const double target_rad : {1.5, 1.0}) {
    const Result<RecordedStop> stop = device_->MoveTo({"stop", {target_rad}}, {});
    ASSERT_TRUE(stop) << stop.error().message;
    EXPECT_NEAR(*stop->axes[0].reported, target_rad, 1e-6);
  }
}

TEST_F(RealLinuxcnc, ItsOwnLimitsAreTold) {
  device_.reset();
  PositionerSettings settings = peer_->Settings();
  settings.axes = {{.name = "z", .device_letter = "Z", .unit = AxisUnit::kMetre}};
  device_ = *(*MakeLinuxcncDriver({}, {.clock = &peer_->Time()}, {}))->OpenPositioner(settings, {});
  const Result<RecordedStop> moved = device_->MoveTo({"low", {-0.05}}, {});
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().message, HasSubstr("would exceed Z's negative limit"));
}

}  // namespace
}  // namespace rigcal
