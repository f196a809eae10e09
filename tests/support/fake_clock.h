#pragma once

#include <functional>
#include <map>
#include <mutex>

#include "core/base/clock.h"

namespace rigcal {

/// Time that passes only where somebody waits for it, at once. Events happen while it passes. Safe to use from several
/// threads; events are called without a lock, by the thread that waits.
class FakeClock final : public Clock {
 public:
  [[nodiscard]] double NowS() const override;
  /// Advances by `seconds`, or up to the event that set the stop token.
  bool Wait(double seconds, const std::stop_token& stop) override;

  /// The same without a stop token.
  void Advance(double seconds) { Wait(seconds, {}); }
  /// Calls `event` when `seconds` from now have passed; what it throws leaves Wait.
  void After(double seconds, std::function<void()> event);
  /// A token that is set when `seconds` from now have passed.
  std::stop_token StopAfter(double seconds);

 private:
  mutable std::mutex mutex_;
  double now_s_ = 0;
  std::multimap<double, std::function<void()>> events_;
};

}  // namespace rigcal
