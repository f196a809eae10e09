#include "drivers/usb/check_usb_descriptors.h"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace rigcal {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// bDescriptorType, USB 3.2 table 9-6; kClassInterface holds the device information of a USB3 Vision camera.
enum DescriptorType : std::uint8_t {
  kDevice = 0x01,
  kConfiguration = 0x02,
  kInterface = 0x04,
  kEndpoint = 0x05,
  kAssociation = 0x0B,
  kClassInterface = 0x24,
  kCompanion = 0x30
};

/// bLength of each: the standard has no other.
constexpr std::size_t kHeaderLength = 2, kDeviceLength = 18, kConfigurationLength = 9, kInterfaceLength = 9,
                      kEndpointLength = 7, kAssociationLength = 8, kCompanionLength = 6, kDeviceInfoLength = 20;
constexpr std::size_t kGuidIndex = 11, kSpeedSupport = 19;          ///< in the device information
constexpr std::uint8_t kDeviceInfoSubtype = 0x01;                   ///< its bDescriptorSubtype
constexpr std::uint8_t kSuperSpeed = 0x08, kSuperSpeedPlus = 0x10;  ///< bits of bmSpeedSupport
constexpr std::uint8_t kMiscellaneous = 0xEF, kUsb3VisionSubclass = 0x05;
constexpr std::uint8_t kControlProtocol = 0, kEventProtocol = 1, kStreamProtocol = 2;
constexpr std::uint8_t kInput = 0x80, kEndpointNumber = 0x0F, kTransferType = 0x03, kBulk = 2;
constexpr int kMostInterfaces = 32;  ///< of one configuration (libusb refuses more)

int Word(Bytes bytes, std::size_t at) {
  return bytes[at] | bytes[at + 1] << 8;
}

struct Endpoint {
  std::size_t offset = 0;
  std::uint8_t address = 0, attributes = 0;
  int packet_bytes = 0;
};

/// One interface or alternate setting.
struct Interface {
  std::size_t offset = 0;
  int number = 0, alternate = 0, num_endpoints = 0;
  bool usb3_vision = false;
  std::uint8_t protocol = 0;
  std::vector<Endpoint> endpoints;
  std::optional<std::uint8_t> guid_index, speeds;  ///< of the device information that follows it
};

/// Reads descriptor by descriptor. Each step hands back the flaw that it found, or nothing.
class Reader {
 public:
  explicit Reader(Bytes bytes) : bytes_(bytes) {}

  std::optional<std::string> Device();
  std::optional<std::string> Configuration();
  std::optional<std::string> Camera() const;

  /// Whether it says that it is a camera, or broke off before it could.
  [[nodiscard]] bool SaysUsb3Vision() const { return seen_usb3_vision_ || (!all_read_ && SaysMiscellaneous()); }
  [[nodiscard]] bool SuperSpeedAble() const;

 private:
  [[nodiscard]] bool SaysMiscellaneous() const {
    return bytes_.size() >= kDeviceLength && bytes_[4] == kMiscellaneous && bytes_[5] == 2 && bytes_[6] == 1;
  }
  std::optional<std::string> One(std::size_t offset, Bytes one);
  std::optional<std::string> OneInterface(std::size_t offset, Bytes one);
  std::optional<std::string> OneEndpoint(std::size_t offset, Bytes one);
  std::optional<std::string> OneAssociation(std::size_t offset, Bytes one);
  std::optional<std::string> OneDeviceInfo(std::size_t offset, Bytes one);
  std::optional<std::string> CountInterfaces() const;
  static std::optional<std::string> ControlEndpoints(const Interface& control);
  static std::optional<std::string> StreamEndpoints(const Interface& stream);

  Bytes bytes_;
  int num_interfaces_ = 0;
  std::vector<Interface> interfaces_;
  bool seen_usb3_vision_ = false;
  bool all_read_ = false;                           ///< the first configuration, to its end
  std::optional<std::pair<int, int>> association_;  ///< first interface and their number, of class EF/05
};

template <typename... Args>
std::string At(std::size_t offset, fmt::format_string<Args...> format, Args&&... args) {
  return fmt::format("offset {}: {}", offset, fmt::format(format, std::forward<Args>(args)...));
}

std::optional<std::string> WrongLength(std::size_t offset, Bytes one, std::string_view name, std::size_t length) {
  if (one.size() == length) return std::nullopt;
  return At(offset, "the {} descriptor has a bLength of {}, not {}", name, one.size(), length);
}

std::optional<std::string> Reader::Device() {
  if (bytes_.size() < kDeviceLength) {
    return At(0, "the device descriptor breaks off after {} of {} bytes", bytes_.size(), kDeviceLength);
  }
  if (bytes_[1] != kDevice) return At(1, "the descriptor has type {:#04x}, not that of a device (0x01)", bytes_[1]);
  if (bytes_[0] != kDeviceLength) {
    return At(0, "the device descriptor has a bLength of {}, not {}", bytes_[0], kDeviceLength);
  }
  if (bytes_[17] == 0) return At(17, "the device has 0 configurations");
  return std::nullopt;
}

std::optional<std::string> Reader::Configuration() {
  const Bytes rest = bytes_.subspan(kDeviceLength);
  if (rest.size() < kConfigurationLength) {
    return At(kDeviceLength, "the configuration descriptor breaks off after {} of {} bytes", rest.size(),
              kConfigurationLength);
  }
  if (rest[1] != kConfiguration) {
    return At(kDeviceLength + 1, "the descriptor has type {:#04x}, not that of a configuration (0x02)", rest[1]);
  }
  if (rest[0] != kConfigurationLength) {
    return At(kDeviceLength, "the configuration descriptor has a bLength of {}, not {}", rest[0], kConfigurationLength);
  }
  const std::size_t total = Word(rest, 2);
  if (total < kConfigurationLength || total > rest.size() || (bytes_[17] == 1 && total != rest.size())) {
    return At(kDeviceLength + 2, "the configuration has a wTotalLength of {}, and {} bytes", total, rest.size());
  }
  num_interfaces_ = rest[4];
  if (num_interfaces_ == 0 || num_interfaces_ > kMostInterfaces) {
    return At(kDeviceLength + 4, "the configuration has {} interfaces, not 1 to {}", num_interfaces_, kMostInterfaces);
  }
  for (std::size_t at = kConfigurationLength; at < total;) {
    const std::size_t left = total - at, length = rest[at];
    if (length < kHeaderLength || length > left) {
      return At(kDeviceLength + at, "a descriptor has a bLength of {}, and {} bytes of the configuration are left",
                length, left);
    }
    if (auto flaw = One(kDeviceLength + at, rest.subspan(at, length))) return flaw;
    at += length;
  }
  all_read_ = true;
  return CountInterfaces();
}

std::optional<std::string> Reader::One(std::size_t offset, Bytes one) {
  switch (one[1]) {
    case kInterface:
      return OneInterface(offset, one);
    case kEndpoint:
      return OneEndpoint(offset, one);
    case kAssociation:
      return OneAssociation(offset, one);
    case kCompanion:
      return WrongLength(offset, one, "endpoint companion", kCompanionLength);
    case kDevice:
    case kConfiguration:
      return At(offset + 1, "a descriptor of type {:#04x} in the middle of a configuration", one[1]);
    case kClassInterface:
      if (!interfaces_.empty() && interfaces_.back().usb3_vision && interfaces_.back().protocol == kControlProtocol) {
        return OneDeviceInfo(offset, one);
      }
      return std::nullopt;
    default:
      return std::nullopt;  // of another class or vendor: passed over by its length
  }
}

std::optional<std::string> Reader::OneInterface(std::size_t offset, Bytes one) {
  const bool usb3_vision = one.size() > 6 && one[5] == kMiscellaneous && one[6] == kUsb3VisionSubclass;
  seen_usb3_vision_ = seen_usb3_vision_ || usb3_vision;
  if (auto flaw = WrongLength(offset, one, "interface", kInterfaceLength)) return flaw;
  interfaces_.push_back({.offset = offset,
                         .number = one[2],
                         .alternate = one[3],
                         .num_endpoints = one[4],
                         .usb3_vision = usb3_vision,
                         .protocol = one[7]});
  return std::nullopt;
}

std::optional<std::string> Reader::OneEndpoint(std::size_t offset, Bytes one) {
  if (interfaces_.empty()) return At(offset, "an endpoint descriptor before any interface");
  // 9 bytes: audio devices of version 1, which share a cable with no camera but are well all the same
  if (one.size() != kEndpointLength && interfaces_.back().usb3_vision) {
    return WrongLength(offset, one, "endpoint", kEndpointLength);
  }
  if (one.size() < kEndpointLength) return WrongLength(offset, one, "endpoint", kEndpointLength);
  interfaces_.back().endpoints.push_back(
      {.offset = offset, .address = one[2], .attributes = one[3], .packet_bytes = Word(one, 4)});
  return std::nullopt;
}

std::optional<std::string> Reader::OneAssociation(std::size_t offset, Bytes one) {
  const bool usb3_vision = one.size() > 5 && one[4] == kMiscellaneous && one[5] == kUsb3VisionSubclass;
  seen_usb3_vision_ = seen_usb3_vision_ || usb3_vision;
  if (auto flaw = WrongLength(offset, one, "interface association", kAssociationLength)) return flaw;
  if (!usb3_vision) return std::nullopt;
  if (association_) return At(offset, "a second interface association of class EF/05");
  association_ = {one[2], one[3]};
  return std::nullopt;
}

std::optional<std::string> Reader::OneDeviceInfo(std::size_t offset, Bytes one) {
  if (one.size() < 3 || one[2] != kDeviceInfoSubtype) return std::nullopt;
  if (auto flaw = WrongLength(offset, one, "device information", kDeviceInfoLength)) return flaw;
  if (one[kGuidIndex] == 0) {
    return At(offset + kGuidIndex, "the device information has no GUID: its string index is 0");
  }
  interfaces_.back().guid_index = one[kGuidIndex];
  interfaces_.back().speeds = one[kSpeedSupport];
  return std::nullopt;
}

std::optional<std::string> Reader::CountInterfaces() const {
  std::set<int> numbers;
  for (const Interface& interface : interfaces_) {
    numbers.insert(interface.number);
    if (std::ssize(interface.endpoints) != interface.num_endpoints) {
      return At(interface.offset + 4, "interface {}.{} has a bNumEndpoints of {}, and {} endpoints", interface.number,
                interface.alternate, interface.num_endpoints, interface.endpoints.size());
    }
  }
  if (std::ssize(numbers) != num_interfaces_) {
    return At(kDeviceLength + 4, "the configuration has a bNumInterfaces of {}, and {} interfaces", num_interfaces_,
              numbers.size());
  }
  return std::nullopt;
}

/// Aravis takes the number of the first endpoint for both directions.
std::optional<std::string> Reader::ControlEndpoints(const Interface& control) {
  if (control.endpoints.size() != 2) {
    return At(control.offset + 4, "the control interface has {} endpoints, not 2", control.endpoints.size());
  }
  const Endpoint &first = control.endpoints[0], &second = control.endpoints[1];
  if ((first.address & kEndpointNumber) != (second.address & kEndpointNumber) ||
      (first.address & kInput) == (second.address & kInput)) {
    return At(first.offset + 2, "the control interface has endpoints {:#04x} and {:#04x}, not one number both ways",
              first.address, second.address);
  }
  return std::nullopt;
}

std::optional<std::string> Reader::StreamEndpoints(const Interface& stream) {
  if (stream.endpoints.size() != 1) {
    return At(stream.offset + 4, "the stream interface has {} endpoints, not 1", stream.endpoints.size());
  }
  if ((stream.endpoints[0].address & kInput) == 0) {
    return At(stream.endpoints[0].offset + 2, "the stream interface has endpoint {:#04x}, which is no input",
              stream.endpoints[0].address);
  }
  return std::nullopt;
}

std::optional<std::string> Reader::Camera() const {
  if (!SaysMiscellaneous()) {
    return At(4, "the device is of class {:02X}/{:02X}/{:02X}, not EF/02/01", bytes_[4], bytes_[5], bytes_[6]);
  }
  const Interface *control = nullptr, *stream = nullptr;
  for (const Interface& interface : interfaces_) {
    if (!interface.usb3_vision) continue;
    for (const Endpoint& endpoint : interface.endpoints) {
      if ((endpoint.address & kEndpointNumber) == 0 || (endpoint.attributes & kTransferType) != kBulk ||
          endpoint.packet_bytes == 0) {
        return At(endpoint.offset + 2,
                  "endpoint {:#04x} has attributes {:#04x} and packets of {} bytes, one of a camera is bulk (0x02)",
                  endpoint.address, endpoint.attributes, endpoint.packet_bytes);
      }
    }
    if (interface.protocol > kStreamProtocol) {
      return At(interface.offset + 7, "interface {} has protocol {}, not 0 to {}", interface.number, interface.protocol,
                kStreamProtocol);
    }
    if (interface.protocol == kEventProtocol) continue;
    const Interface*& place = interface.protocol == kControlProtocol ? control : stream;
    if (place != nullptr) {
      return At(interface.offset + 7, "interface {}.{} is a second one of protocol {}", interface.number,
                interface.alternate, interface.protocol);
    }
    place = &interface;
    if (auto flaw = place == control ? ControlEndpoints(interface) : StreamEndpoints(interface)) return flaw;
  }
  if (control == nullptr) return At(kDeviceLength, "the configuration has no control interface (EF/05/00)");
  if (stream == nullptr) return At(kDeviceLength, "the configuration has no stream interface (EF/05/02)");
  if (!control->guid_index) {
    return At(control->offset, "no device information of {} bytes follows the control interface", kDeviceInfoLength);
  }
  if (!association_) return At(kDeviceLength, "the configuration has no interface association of class EF/05");
  const auto [first, count] = *association_;
  for (const Interface* interface : {control, stream}) {
    if (interface->number < first || interface->number >= first + count) {
      return At(interface->offset + 2, "interface {} is outside its association of {} from {}", interface->number,
                count, first);
    }
  }
  return std::nullopt;
}

bool Reader::SuperSpeedAble() const {
  for (const Interface& interface : interfaces_) {
    if (interface.speeds) return (*interface.speeds & (kSuperSpeed | kSuperSpeedPlus)) != 0;
  }
  return false;
}

}  // namespace

UsbDescriptorCheck CheckUsbDescriptors(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  std::optional<std::string> flaw = reader.Device();
  if (!flaw) flaw = reader.Configuration();
  UsbDescriptorCheck check{.says_usb3_vision = reader.SaysUsb3Vision(), .super_speed_able = reader.SuperSpeedAble()};
  if (!flaw && check.says_usb3_vision) flaw = reader.Camera();
  check.flaw = flaw.value_or("");
  return check;
}

}  // namespace rigcal
