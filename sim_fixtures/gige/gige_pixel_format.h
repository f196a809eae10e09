#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace rigcal::sim {

/// A pixel format of GenICam's Pixel Format Naming Convention, unpacked: 8 bits, or 10, 12, 16 in the low bits of two
/// bytes, the lower one first.
struct GigePixelFormat {
  std::string_view name;
  std::uint32_t code = 0;  ///< of the convention
  int bits = 8;

  [[nodiscard]] int BytesPerPixel() const { return bits > 8 ? 2 : 1; }
};

/// All that the device has; the first is the one that it wakes up with.
std::span<const GigePixelFormat> GigePixelFormats();

std::optional<GigePixelFormat> FindGigePixelFormat(std::uint32_t code);

}  // namespace rigcal::sim
