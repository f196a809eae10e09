#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/clock.h"
#include "core/scene/rig_devices.h"
#include "drivers/linuxcnc/rsh_session.h"
#include "drivers/positioner_device.h"

namespace rigcal {

/// A table or gantry behind LinuxCNC. Positions are machine coordinates.
class LinuxcncPositioner final : public PositionerDevice {
 public:
  /// Connects to settings.address and takes control; nothing moves then. The clock outlives it. Errors: kBadInput (an
  /// address that is none, axes that cannot be read back), those of RshSession::Open.
  static Result<std::unique_ptr<PositionerDevice>> Open(const PositionerSettings& settings, Clock& clock,
                                                        const std::stop_token& stop);
  ~LinuxcncPositioner() override { Halt(); }

  /// Connects again where that is needed, switches the power on, and homes the machine where it is not homed. An
  /// emergency stop is never reset.
  Result<void> Home(const std::stop_token& stop) override;
  Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) override;
  Result<void> FinishStop(const Result<void>& taken) override;
  void Halt() noexcept override;

 private:
  LinuxcncPositioner(RshSession session, PositionerSettings settings, Clock& clock);

  Result<void> HomeAtRest(const std::stop_token& stop);
  Result<void> SwitchOn(const std::stop_token& stop);
  /// Whether it takes moves, which it does not before it is homed. Leaves it in the mode for them.
  Result<bool> TakesMoves(const std::stop_token& stop);
  Result<void> AwaitHomed(const std::stop_token& stop);

  Result<RecordedStop> MoveToRest(const StopTarget& target, const std::stop_token& stop);
  /// Where it stands, ready to move. Errors: kDevice (emergency stop, power, moved by somebody).
  Result<RshPosition> StandsReady(const std::stop_token& stop);
  /// Moves in a straight line to `target` and waits until it rests; hands back where.
  Result<RshPosition> Travel(const std::vector<double>& target, const RshPosition& from, double end_s,
                             const std::stop_token& stop);
  /// What keeps it from moving. Errors: kDevice with the reason, its own messages included.
  Result<void> CheckWell(const RshState& state, const std::stop_token& stop);
  /// "joint 2: MAXHARD": of joints that are at a limit or have a fault; empty where none is.
  Result<std::string> JointTrouble(const std::stop_token& stop);
  /// Stops the machine; the Error with the axes that it is about, and a warning when it could not be stopped.
  [[nodiscard]] tl::unexpected<Error> Stopped(const Error& error);

  [[nodiscard]] std::vector<double> AxesAt(const RshPosition& at) const;

  RshSession session_;
  PositionerSettings settings_;
  Clock& clock_;
  bool approached_ = false;            ///< the last move ended from the side of `approach`
  std::optional<RshPosition> rested_;  ///< where the last move ended
};

}  // namespace rigcal
