#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "sim_fixtures/gige/big_endian.h"

namespace rigcal::sim {

/// The device's registers: bytes, numbers with the highest byte first. Addresses are the caller's to check (Holds).
class GigeMemory {
 public:
  GigeMemory();

  [[nodiscard]] bool Holds(std::uint32_t address, std::size_t size) const;
  [[nodiscard]] std::span<const std::uint8_t> Read(std::uint32_t address, std::size_t size) const;
  void Write(std::uint32_t address, std::span<const std::uint8_t> bytes);

  [[nodiscard]] std::uint32_t Number(std::uint32_t address) const;
  void SetNumber(std::uint32_t address, std::uint32_t value);
  [[nodiscard]] float Float(std::uint32_t address) const;
  void SetFloat(std::uint32_t address, float value);
  void SetText(std::uint32_t address, std::string_view text);

 private:
  Bytes bytes_;
};

}  // namespace rigcal::sim
