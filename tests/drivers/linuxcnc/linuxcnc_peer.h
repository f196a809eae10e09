#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "sim_fixtures/linuxcnc/linuxcnc_simulator.h"
#include "tests/drivers/positioner_contract.h"
#include "tests/support/fake_clock.h"

namespace rigcal {

/// A simulated LinuxCNC with its emergency stop released. Its motion goes by a clock that passes where the driver waits
/// for motion; answers come in real time. A wait for an answer that does not come ends when the guard lets a day pass.
class LinuxcncPeer final : public PositionerPeer {
 public:
  LinuxcncPeer();

  FakeClock& Time() override { return clock_; }
  double SlackS() const override { return 0; }
  std::stop_token StopAfter(double seconds) override { return clock_.StopAfter(seconds); }
  PositionerSettings Settings() override;
  Result<std::unique_ptr<PositionerDevice>> Open() override { return Open(Settings()); }
  Result<std::unique_ptr<PositionerDevice>> Open(const PositionerSettings& settings);
  std::vector<double> Place(int number) override;
  std::vector<double> Position() override;
  /// What was sent last may still be under way: waits until the machine stands, or has been seen to have been pushed.
  bool Moving() override;
  std::optional<std::string> WhyNot(PositionerFault fault) override;
  void Set(PositionerFault fault, bool on) override;

  void With(const std::function<void(sim::LinuxcncMachine&)>& use) { simulator_->With(use); }
  sim::LinuxcncSimulator& Simulator() { return *simulator_; }

 private:
  FakeClock clock_;
  std::unique_ptr<sim::LinuxcncSimulator> simulator_;
  bool pushed_ = false;
  std::jthread guard_;
};

}  // namespace rigcal
