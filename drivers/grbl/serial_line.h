#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/descriptor.h"
#include "core/base/result.h"
#include "drivers/grbl/grbl_protocol.h"

namespace rigcal {

/// A serial device, opened raw at GRBL's 115200 baud, 8 data bits, no parity, and held for this program alone. Waits
/// are at most kSlice_ms, so that whoever waits longer can look at his clock and stop token. Errors name the device.
class SerialLine {
 public:
  static constexpr int kSlice_ms = 20;
  static constexpr std::string_view kHeld = "another program holds it";  ///< the end of Open's message then

  SerialLine(SerialLine&&) = default;
  ~SerialLine();

  /// Errors: kNotFound, kBadInput (not a serial device), kDevice (no right to it, held by another program).
  static Result<SerialLine> Open(const std::string& path);

  /// Sends all of it. Errors: kDevice (the line is gone), kTimeout (the far side takes nothing).
  Result<void> Write(std::string_view bytes);

  /// The next line; nothing when none came within kSlice_ms. Errors: kDevice (the line is gone).
  Result<std::optional<std::string>> ReadLine();

  [[nodiscard]] const std::string& Path() const { return path_; }

 private:
  SerialLine(Descriptor descriptor, std::string path) : descriptor_(std::move(descriptor)), path_(std::move(path)) {}
  [[nodiscard]] tl::unexpected<Error> Gone(int failure) const;
  /// Waits for one of poll(2)'s events for a slice; whether it came.
  [[nodiscard]] bool Await(short events) const;

  Descriptor descriptor_;
  std::string path_;
  LineSplitter splitter_;
};

}  // namespace rigcal
