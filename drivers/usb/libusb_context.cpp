#include "drivers/usb/libusb_context.h"

#include <array>
#include <vector>

#include "core/base/joined.h"

namespace rigcal {

constexpr std::size_t kMostPorts = 7;  ///< on the way to a device: USB 3.2 allows five hubs behind the root hub

Result<LibusbContext> OpenLibusb() {
  libusb_context* context = nullptr;
  if (const int failure = libusb_init(&context); failure != LIBUSB_SUCCESS) {
    return Fail(ErrorCode::kDevice, "USB: libusb cannot be used: {}", libusb_error_name(failure));
  }
  return LibusbContext(context);
}

std::string PortPathOf(libusb_device* device) {
  std::array<std::uint8_t, kMostPorts> ports{};
  const int count = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  const int bus = libusb_get_bus_number(device);
  if (count <= 0) return fmt::format("usb{}", bus);  // a root hub
  std::vector<std::string> texts;
  for (int i = 0; i < count; ++i) texts.push_back(std::to_string(ports[static_cast<std::size_t>(i)]));
  return fmt::format("{}-{}", bus, Joined(texts, "."));
}

}  // namespace rigcal
