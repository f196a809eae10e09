#include "tests/support/fake_clock.h"

#include <algorithm>
#include <utility>

namespace rigcal {

double FakeClock::NowS() const {
  const std::lock_guard lock(mutex_);
  return now_s_;
}

bool FakeClock::Wait(double seconds, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const double end_s = now_s_ + std::max(0.0, seconds);
  while (!stop.stop_requested()) {
    const auto next = events_.begin();
    if (next == events_.end() || next->first > end_s) {
      now_s_ = std::max(now_s_, end_s);  // another thread may have advanced it further
      return true;
    }
    now_s_ = std::max(now_s_, next->first);
    const std::function<void()> event = std::move(next->second);
    events_.erase(next);
    lock.unlock();
    event();
    lock.lock();
  }
  return false;
}

void FakeClock::After(double seconds, std::function<void()> event) {
  const std::lock_guard lock(mutex_);
  events_.emplace(now_s_ + seconds, std::move(event));
}

std::stop_token FakeClock::StopAfter(double seconds) {
  std::stop_source stop;
  std::stop_token token = stop.get_token();
  After(seconds, [stop]() mutable { stop.request_stop(); });
  return token;
}

}  // namespace rigcal
