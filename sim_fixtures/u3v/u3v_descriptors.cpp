#include "sim_fixtures/u3v/u3v_descriptors.h"

namespace rigcal::sim {
namespace {

constexpr std::uint8_t kDevice = 1, kConfiguration = 2, kInterface = 4, kEndpoint = 5, kAssociation = 11,
                       kClassInterface = 0x24, kCompanion = 0x30;
constexpr std::uint8_t kBulk = 2, kInterrupt = 3;

/// One descriptor: its length and type are put before `rest`.
void Put(Bytes& to, std::uint8_t type, const Bytes& rest) {
  to.push_back(static_cast<std::uint8_t>(rest.size() + 2));
  to.push_back(type);
  to.insert(to.end(), rest.begin(), rest.end());
}

void PutEndpoint(Bytes& to, std::uint8_t address) {
  Put(to, kEndpoint, {address, kBulk, 0x00, 0x04, 0});  // packets of 1024 bytes
  Put(to, kCompanion, {0, 0, 0, 0});
}

/// Behind the device descriptor, with its total length.
void PutConfiguration(Bytes& to, std::uint8_t num_interfaces, const Bytes& rest) {
  const auto total = static_cast<std::uint16_t>(9 + rest.size());
  Put(to, kConfiguration,
      {static_cast<std::uint8_t>(total & 0xff), static_cast<std::uint8_t>(total >> 8), num_interfaces, 1, 0, 0x80, 50});
  to.insert(to.end(), rest.begin(), rest.end());
}

}  // namespace

Bytes U3vDescriptors(std::uint16_t firmware_bcd) {
  Bytes bytes;
  // USB 3.0, class EF/02/01, packets of 2^9 bytes; vendor 1209 is for tests (pid.codes)
  Put(bytes, kDevice,
      {0x00, 0x03, 0xEF, 0x02, 0x01, 9, 0x09, 0x12, 0x01, 0x00, static_cast<std::uint8_t>(firmware_bcd & 0xff),
       static_cast<std::uint8_t>(firmware_bcd >> 8), kVendorText, kModelText, kSerialText, 1});
  Bytes rest;
  Put(rest, kAssociation, {0, 2, 0xEF, 0x05, 0x00, 0});
  Put(rest, kInterface, {0, 0, 2, 0xEF, 0x05, 0x00, 0});
  // GenCP 1.1, USB3 Vision 1.1, texts, all speeds up to 5 Gbit/s
  Put(rest, kClassInterface,
      {1, 1, 0, 1, 0, 1, 0, 1, 0, kGuidText, kVendorText, kModelText, 0, 0, 0, kSerialText, 0, 0x0E});
  PutEndpoint(rest, kAnswerEndpoint);
  PutEndpoint(rest, kCommandEndpoint);
  Put(rest, kInterface, {1, 0, 1, 0xEF, 0x05, 0x02, 0});
  PutEndpoint(rest, kStreamEndpoint);
  PutConfiguration(bytes, 2, rest);
  return bytes;
}

Bytes HubDescriptors() {
  Bytes bytes;
  Put(bytes, kDevice, {0x00, 0x03, 9, 0, 3, 9, 0x6b, 0x1d, 0x03, 0x00, 0x00, 0x06, 0, 0, 0, 1});
  Bytes rest;
  Put(rest, kInterface, {0, 0, 1, 9, 0, 0, 0});
  Put(rest, kEndpoint, {0x81, kInterrupt, 4, 0, 12});
  PutConfiguration(bytes, 1, rest);
  return bytes;
}

}  // namespace rigcal::sim
