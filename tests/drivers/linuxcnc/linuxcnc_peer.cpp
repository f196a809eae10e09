#include "tests/drivers/linuxcnc/linuxcnc_peer.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "drivers/linuxcnc/linuxcnc_driver.h"

namespace rigcal {
namespace {

using sim::LinuxcncMachine;
using sim::LinuxcncTrouble;

constexpr double kPlaceStep_rad = 0.8;  ///< 46 degrees: more than a second at 30 degrees/s
constexpr double kSpeed_rad_s = std::numbers::pi / 6;
constexpr double kHang_s = 60;    ///< real time beyond which a wait that should have ended hangs
constexpr double kDay_s = 86400;  ///< more than any wait of the driver
constexpr auto kSlice = std::chrono::milliseconds(5);

}  // namespace

LinuxcncPeer::LinuxcncPeer() : simulator_(*sim::LinuxcncSimulator::Start(clock_)) {
  With([](LinuxcncMachine& machine) { machine.SetEmergencyStop(false, false); });
  guard_ = std::jthread([this](const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_for(lock, stop, std::chrono::duration<double>(kHang_s), [] { return false; });
    while (!stop.stop_requested()) clock_.Advance(kDay_s), std::this_thread::sleep_for(20 * kSlice);
  });
}

PositionerSettings LinuxcncPeer::Settings() {
  return {.driver = "linuxcnc",
          .address = simulator_->Address(),
          .axes = {{.name = "table", .device_letter = "C", .least = -0.5, .most = 6.3, .speed = kSpeed_rad_s}},
          .move_timeout_s = 20};
}

Result<std::unique_ptr<PositionerDevice>> LinuxcncPeer::Open(const PositionerSettings& settings) {
  return (*MakeLinuxcncDriver({}, {.clock = &clock_}, {}))->OpenPositioner(settings, {});
}

std::vector<double> LinuxcncPeer::Place(int number) {
  return {(1 + number) * kPlaceStep_rad};
}

std::vector<double> LinuxcncPeer::Position() {
  double c_deg = 0;
  With([&](LinuxcncMachine& machine) { c_deg = machine.Position('C'); });
  return {c_deg * std::numbers::pi / 180};
}

bool LinuxcncPeer::Moving() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kHang_s);
  bool moving = true;
  while (moving && std::chrono::steady_clock::now() < end) {
    With([&](LinuxcncMachine& machine) { moving = machine.Moving(); });
    if (std::exchange(pushed_, false)) break;
    if (moving) std::this_thread::sleep_for(kSlice);
  }
  return moving;
}

std::optional<std::string> LinuxcncPeer::WhyNot(PositionerFault /*fault*/) {
  return std::nullopt;
}

void LinuxcncPeer::Set(PositionerFault fault, bool on) {
  if (fault == PositionerFault::kException) {
    clock_.After(0.3, [] { throw std::runtime_error("in the middle of a move"); });
  }
  if (fault == PositionerFault::kPushed) {
    simulator_->Push("set mdi G53 G1 C3000 F60");
    pushed_ = true;
  }
  With([&](LinuxcncMachine& machine) {
    if (fault == PositionerFault::kHoming) machine.Faults().no_home = on;
    if (fault == PositionerFault::kStuck) machine.Faults().stuck = on;
    if (fault == PositionerFault::kOffTarget) machine.Faults().miss = on ? 0.6 : 0;  // degrees
    if (fault == PositionerFault::kAlarm) machine.Faults().in_motion = LinuxcncTrouble::kLimit;
    if (fault == PositionerFault::kGone) machine.Faults().in_motion = LinuxcncTrouble::kCut;
  });
}

}  // namespace rigcal
