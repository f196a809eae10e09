#pragma once

#include <mutex>
#include <optional>
#include <string>

#include "core/base/clock.h"
#include "drivers/driver.h"

namespace rigcal {

/// What a replay's cameras and positioner share: the recording, and at which of its stops they are.
class ReplayedRig {
 public:
  ReplayedRig(RecordedPictures pictures, Subject subject, bool at_recorded_speed, Clock& clock);

  [[nodiscard]] const Recording& Content() const { return pictures_.recording; }
  [[nodiscard]] Clock& Time() const { return clock_; }

  /// The stop of this id, or else the one with these commanded axes. Errors: kDevice.
  [[nodiscard]] Result<int> FindStop(const StopTarget& target) const;
  /// Goes there, at the recorded speed no earlier than it was reached then. Errors: kCancelled; it has not moved then.
  Result<void> GoTo(int stop, const std::stop_token& token);
  [[nodiscard]] std::optional<int> CurrentStop() const;

  /// The picture that the camera has at a stop. Errors: kDevice, also where the recording has none.
  [[nodiscard]] Result<CapturedPicture> PictureAt(int camera, int stop) const;

 private:
  /// Seconds since some fixed moment at which the first picture of the stop was taken, where that is known.
  [[nodiscard]] std::optional<double> TakenAtS(int stop) const;

  const RecordedPictures pictures_;
  const Subject subject_;
  const bool at_recorded_speed_;
  Clock& clock_;
  mutable std::mutex mutex_;
  std::optional<int> current_stop_;
  std::optional<double> clock_minus_recorded_s_;  ///< fixed when the first stop is reached
};

}  // namespace rigcal
