#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/base/clock.h"
#include "core/scene/rig_devices.h"
#include "drivers/grbl/grbl_board.h"
#include "drivers/positioner_device.h"

namespace rigcal {

/// A table or gantry behind a GRBL 1.1 controller. Positions are its work coordinates (G54).
class GrblPositioner final : public PositionerDevice {
 public:
  /// Opens the serial device at settings.address; nothing moves then. The clock outlives it. Errors: kBadInput (axes
  /// that GRBL has not), those of GrblBoard::Open.
  static Result<std::unique_ptr<PositionerDevice>> Open(const PositionerSettings& settings, Clock& clock,
                                                        const std::stop_token& stop);
  ~GrblPositioner() override { Halt(); }

  /// A homing cycle, once: later calls return at once while the position holds. A machine without limit switches
  /// ($22=0) has its zero where it stood when it was switched on.
  Result<void> Home(const std::stop_token& stop) override;
  Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) override;
  Result<void> FinishStop(const Result<void>& taken) override;
  void Halt() noexcept override;

 private:
  GrblPositioner(GrblBoard board, const PositionerSettings& settings, std::vector<int> axes, Clock& clock);

  Result<void> HomeAtRest(const std::stop_token& stop);
  /// Where it stands, ready to move. Errors: kDevice (locked, door, reset, moved by somebody).
  Result<GrblPosition> StandsReady(const std::stop_token& stop);
  /// Moves in a straight line to `target` and waits until it rests there; hands back where.
  Result<GrblPosition> Travel(const StopTarget& target, const GrblPosition& from, double end_s,
                              const std::stop_token& stop);
  /// The axes of the settings, radians or metres.
  [[nodiscard]] std::vector<double> AxesAt(const GrblPosition& at) const;
  /// Why a jog was refused: the state of the controller where that tells it, else what it answered.
  tl::unexpected<Error> WhyRefused(const Error& answered, const std::stop_token& stop);
  /// Errors: kDevice: the state is none in which a move goes on.
  [[nodiscard]] Result<void> CheckMoving(const GrblStatus& status) const;
  /// Errors: also kDevice: it moves.
  [[nodiscard]] Result<void> CheckIdle(const GrblStatus& status) const;
  /// The same Error with the axes that it is about.
  [[nodiscard]] tl::unexpected<Error> WithAxes(const Error& error);

  GrblBoard board_;
  PositionerSettings settings_;
  std::vector<int> axes_;            ///< index into X, Y, Z of each axis of the settings
  std::vector<double> speed_per_s_;  ///< of each axis, controller units
  Clock& clock_;
  bool homed_ = false;                  ///< the position holds
  bool approached_ = false;             ///< the last move ended from the side of `approach`
  std::optional<GrblPosition> rested_;  ///< where the last move ended
};

}  // namespace rigcal
