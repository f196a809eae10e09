#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "drivers/acquire/acquire.h"

namespace rigcal {

/// Splits the time of an acquisition into its phases and tells the listener of each one as it begins.
class PhaseTimer {
 public:
  PhaseTimer(const Clock& clock, std::optional<int> num_stops, std::function<void(const AcquisitionProgress&)> listener)
      : clock_(clock), listener_(std::move(listener)), begin_s_(clock.NowS()), num_stops_(num_stops) {}

  void Enter(AcquisitionPhase phase, int stop) {
    Mark();
    phase_ = phase;
    stop_ = stop;
    if (listener_) listener_({phase, stop, num_stops_});
  }

  /// The same at the stop of the latest phase.
  void Enter(AcquisitionPhase phase) { Enter(phase, stop_); }

  /// The times up to now.
  AcquisitionTimes Times() {
    Mark();
    return times_;
  }

 private:
  double& Of(AcquisitionPhase phase) {
    switch (phase) {
      case AcquisitionPhase::kMoving:
        return times_.moving_s;
      case AcquisitionPhase::kSettling:
        return times_.settling_s;
      case AcquisitionPhase::kTaking:
        return times_.taking_s;
      case AcquisitionPhase::kStoring:
        break;
    }
    return times_.storing_s;
  }

  void Mark() {
    const double now_s = clock_.NowS();
    Of(phase_) += now_s - begin_s_;
    begin_s_ = now_s;
  }

  const Clock& clock_;
  std::function<void(const AcquisitionProgress&)> listener_;
  AcquisitionPhase phase_ = AcquisitionPhase::kMoving;
  double begin_s_;
  int stop_ = 0;
  std::optional<int> num_stops_;
  AcquisitionTimes times_;
};

}  // namespace rigcal
