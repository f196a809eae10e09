#pragma once

#include "sim_fixtures/u3v/little_endian.h"

namespace rigcal::sim {

/// Indices of a simulated camera's USB texts.
inline constexpr std::uint8_t kVendorText = 1, kModelText = 2, kSerialText = 3, kGuidText = 4;
/// Its endpoints: commands and their answers, pictures.
inline constexpr std::uint8_t kCommandEndpoint = 0x01, kAnswerEndpoint = 0x81, kStreamEndpoint = 0x82;

/// The device descriptor and the configuration of a USB3 Vision camera, every length as it should be: association,
/// control interface with device information, stream interface. `firmware_bcd` 0x0210 is 2.10. What a test wants to be
/// malformed it changes in the bytes.
Bytes U3vDescriptors(std::uint16_t firmware_bcd = 0x0100);

/// Those of a hub.
Bytes HubDescriptors();

}  // namespace rigcal::sim
