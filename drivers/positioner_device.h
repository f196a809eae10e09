#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/rigid3.h"
#include "core/scene/recording.h"

namespace rigcal {

/// Where a stop is wanted, in the order of the device's axes: radians or metres. For an arm that somebody else moves:
/// nothing; it says itself where it went.
struct StopTarget {
  std::string id;
  std::vector<double> axes;
};

/// The turntable, gantry or arm, connected. Used by one thread. Whatever ends its use (an error, a stop token, an
/// exception, destruction) leaves the machine stopped. Every Error names device and axis. Codes: kDevice (alarm, limit,
/// connection), kTimeout, kCancelled, kBadInput (a target outside the soft limits: nothing moves then).
class PositionerDevice {
 public:
  virtual ~PositionerDevice() = default;
  PositionerDevice() = default;
  PositionerDevice(const PositionerDevice&) = delete;
  PositionerDevice& operator=(const PositionerDevice&) = delete;

  /// Finds the axes' zeros where the device does not know them. Returns at rest.
  virtual Result<void> Home(const std::stop_token& stop) = 0;

  /// Moves and returns when the machine rests there: commanded and reported position as a recording has them (settling
  /// is the caller's). Errors also: the reported position is off by more than the tolerance.
  virtual Result<RecordedStop> MoveTo(const StopTarget& target, const std::stop_token& stop) = 0;

  /// For a device that somebody else moves: waits until it rests at its next stop, which has the id and place that he
  /// says; nothing when there is no further one. Errors also kUnsupported: the device goes where it is told.
  virtual Result<std::optional<RecordedStop>> NextStop(const std::stop_token& /*stop*/) {
    return Fail(ErrorCode::kUnsupported, "the positioner goes where it is told, it has no stops of its own");
  }

  /// Tells whoever moves the device that the pictures of the stop are taken, or why not (an arm's program waits for
  /// it).
  virtual Result<void> FinishStop(const Result<void>& taken) = 0;

  /// Stops all motion now. Never waits longer than a second; safe to call at any time.
  virtual void Halt() noexcept = 0;
};

}  // namespace rigcal
