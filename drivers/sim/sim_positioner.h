#pragma once

#include <memory>

#include "drivers/sim/sim_rig.h"

namespace rigcal {

/// The turntable of the simulated studio: one axis, which reports where it stands.
class SimPositioner final : public PositionerDevice {
 public:
  /// Errors: kUnsupported when the settings have other than one axis in radians.
  static Result<std::unique_ptr<PositionerDevice>> Open(std::shared_ptr<SimRig> rig,
                                                        const PositionerSettings& settings);
  ~SimPositioner() override { Halt(); }

  Result<void> Home(const std::stop_token& stop) override;
  Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) override;
  Result<void> FinishStop(const Result<void>& taken) override;
  void Halt() noexcept override;

 private:
  SimPositioner(std::shared_ptr<SimRig> rig, PositionerSettings settings);
  /// Turns to an angle and waits for the end of it; halts the table unless it got there.
  Result<void> Turn(double target_rad, const std::stop_token& stop);
  Result<void> WaitForEnd(double target_rad, const std::stop_token& stop);

  std::shared_ptr<SimRig> rig_;
  PositionerSettings settings_;
  double speed_rad_s_;
};

}  // namespace rigcal
