#include "sim_fixtures/gige/gige_memory.h"

#include <algorithm>
#include <bit>

#include "core/base/ensure.h"
#include "sim_fixtures/gige/gige_registers.h"

namespace rigcal::sim {

GigeMemory::GigeMemory() : bytes_(kMemory_bytes) {}

bool GigeMemory::Holds(std::uint32_t address, std::size_t size) const {
  return address <= bytes_.size() && size <= bytes_.size() - address;
}

std::span<const std::uint8_t> GigeMemory::Read(std::uint32_t address, std::size_t size) const {
  Ensure(Holds(address, size), "an address was checked before it is read");
  return std::span(bytes_).subspan(address, size);
}

void GigeMemory::Write(std::uint32_t address, std::span<const std::uint8_t> bytes) {
  Ensure(Holds(address, bytes.size()), "an address was checked before it is written");
  std::ranges::copy(bytes, bytes_.begin() + address);
}

std::uint32_t GigeMemory::Number(std::uint32_t address) const {
  return static_cast<std::uint32_t>(GetBigEndian(Read(address, 4)));
}

void GigeMemory::SetNumber(std::uint32_t address, std::uint32_t value) {
  Bytes bytes;
  PutBigEndian(bytes, value, 4);
  Write(address, bytes);
}

float GigeMemory::Float(std::uint32_t address) const {
  return std::bit_cast<float>(Number(address));
}

void GigeMemory::SetFloat(std::uint32_t address, float value) {
  SetNumber(address, std::bit_cast<std::uint32_t>(value));
}

void GigeMemory::SetText(std::uint32_t address, std::string_view text) {
  Write(address, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  SetNumber(address + static_cast<std::uint32_t>(text.size()), 0);  // its end; every text has room behind it
}

}  // namespace rigcal::sim
