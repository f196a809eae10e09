#pragma once

#include "drivers/positioner_device.h"

namespace rigcal {

/// A robot arm that somebody else moves: it is not told where to go, it says where it is.
class Arm : public PositionerDevice {
 public:
  /// Nothing to do: an arm knows its zeros.
  Result<void> Home(const std::stop_token& stop) final;

  /// NextStop, which must be there; the target has no axes, and the stop has the arm's own id. Errors: also kBadInput:
  /// a target with axes; kDevice: the arm has no further stop.
  Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) final;
};

}  // namespace rigcal
