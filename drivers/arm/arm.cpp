#include "drivers/arm/arm.h"

namespace rigcal {

Result<void> Arm::Home(const std::stop_token& stop) {
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "arm: homing was stopped on request");
  return {};
}

Result<RecordedStop> Arm::MoveTo(const StopTarget& target, const std::stop_token& stop) {
  if (!target.axes.empty()) {
    return Fail(ErrorCode::kBadInput, "arm: stop '{}' has {} axes, an arm has none and says itself where it goes",
                target.id, target.axes.size());
  }
  Result<std::optional<RecordedStop>> next = NextStop(stop);
  if (!next) return Fail(next.error());
  if (*next) return std::move(**next);
  return Fail(ErrorCode::kDevice, "arm: has no further stop, '{}' was expected", target.id);
}

}  // namespace rigcal
