#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace rigcal::sim {

using Bytes = std::vector<std::uint8_t>;

/// Numbers as USB and USB3 Vision have them, the lowest byte first, as this machine has them too.
template <typename Number>
Number GetLittle(std::span<const std::uint8_t> from, std::size_t at) {
  Number number;
  std::memcpy(&number, from.subspan(at, sizeof(number)).data(), sizeof(number));
  return number;
}

template <typename Number>
void SetLittle(std::span<std::uint8_t> to, std::size_t at, Number number) {
  std::memcpy(to.subspan(at, sizeof(number)).data(), &number, sizeof(number));
}

}  // namespace rigcal::sim
