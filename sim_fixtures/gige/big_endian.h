#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace rigcal::sim {

using Bytes = std::vector<std::uint8_t>;

/// Appends the lowest `count` bytes of a number, the highest of them first, as GigE Vision sends all of its numbers.
inline void PutBigEndian(Bytes& to, std::uint64_t value, int count) {
  for (int shift = 8 * (count - 1); shift >= 0; shift -= 8) to.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// The number in all of `from`, at most 8 bytes.
inline std::uint64_t GetBigEndian(std::span<const std::uint8_t> from) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : from) value = value << 8 | byte;
  return value;
}

}  // namespace rigcal::sim
