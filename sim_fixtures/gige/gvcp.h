#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sim_fixtures/gige/big_endian.h"

namespace rigcal::sim {

inline constexpr std::uint16_t kGvcpPort = 3956;  ///< registered for GigE Vision; the protocol knows no other

/// Commands of the GigE Vision control protocol that the device knows; an answer's command is one more.
enum class GvcpCommand : std::uint16_t {
  kDiscovery = 0x0002,
  kPacketResend = 0x0040,
  kReadRegister = 0x0080,
  kWriteRegister = 0x0082,
  kReadMemory = 0x0084,
  kWriteMemory = 0x0086,
};

enum class GvcpStatus : std::uint16_t {
  kSuccess = 0,
  kNotImplemented = 0x8001,
  kInvalidParameter = 0x8002,
  kInvalidAddress = 0x8003,
  kWriteProtect = 0x8004,
  kBadAlignment = 0x8005,
  kAccessDenied = 0x8006,
};

struct GvcpRequest {
  GvcpCommand command = GvcpCommand::kDiscovery;
  std::uint16_t id = 0;
  bool wants_answer = true;
  std::span<const std::uint8_t> payload;  ///< into the bytes that were parsed
};

/// A datagram as a request; nothing when it is none.
std::optional<GvcpRequest> ParseGvcp(std::span<const std::uint8_t> datagram);

/// The answer to a request as a datagram.
Bytes GvcpAnswer(const GvcpRequest& request, GvcpStatus status, std::span<const std::uint8_t> payload);

}  // namespace rigcal::sim
