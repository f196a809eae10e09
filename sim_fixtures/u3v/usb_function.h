#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace rigcal::sim {

/// What an emulated USB device does. Called by one thread at a time, of the test bed's choice.
class UsbFunction {
 public:
  virtual ~UsbFunction() = default;
  UsbFunction() = default;
  UsbFunction(const UsbFunction&) = delete;
  UsbFunction& operator=(const UsbFunction&) = delete;

  /// It was plugged in: it has forgotten everything.
  virtual void PowerOn() = 0;
  /// Whether a program may take its interfaces; otherwise somebody else has them.
  [[nodiscard]] virtual bool MayBeClaimed() const { return true; }
  /// A transfer to it.
  virtual void Take(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) = 0;
  /// A transfer from it into `room`: how many bytes, or nothing as long as there is nothing to give.
  virtual std::optional<std::size_t> Give(std::uint8_t endpoint, std::span<std::uint8_t> room) = 0;
};

}  // namespace rigcal::sim
