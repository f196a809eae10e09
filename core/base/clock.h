#pragma once

#include <stop_token>

namespace rigcal {

/// Time as the parts that wait see it, so that tests can hold it. Everything that waits takes one of these.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Seconds since some fixed moment; never goes back.
  [[nodiscard]] virtual double NowS() const = 0;
  /// Waits until `seconds` have passed or the stop token is set; true when the time has passed.
  virtual bool Wait(double seconds, const std::stop_token& stop) = 0;
};

/// The machine's steady clock.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] double NowS() const override;
  bool Wait(double seconds, const std::stop_token& stop) override;
};

}  // namespace rigcal
