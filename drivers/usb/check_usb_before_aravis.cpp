#include "drivers/usb/check_usb_before_aravis.h"

#include <span>

#include "drivers/usb/check_usb_descriptors.h"
#include "drivers/usb/libusb_context.h"
#include "drivers/usb/usb_device.h"

namespace rigcal {
namespace {

constexpr int kUsb3VisionClass = 0xEF, kUsb3VisionSubclass = 0x05;  ///< of an interface

struct FreeConfiguration {
  void operator()(libusb_config_descriptor* configuration) const { libusb_free_config_descriptor(configuration); }
};
struct FreeList {
  void operator()(libusb_device** list) const { libusb_free_device_list(list, 1); }
};

bool HasCameraInterfaceWithoutEndpoint(const libusb_config_descriptor& configuration) {
  for (const libusb_interface& interface : std::span(configuration.interface, configuration.bNumInterfaces)) {
    if (interface.num_altsetting <= 0) continue;
    for (const libusb_interface_descriptor& setting :
         std::span(interface.altsetting, static_cast<std::size_t>(interface.num_altsetting))) {
      if (setting.bInterfaceClass == kUsb3VisionClass && setting.bInterfaceSubClass == kUsb3VisionSubclass &&
          setting.bNumEndpoints == 0) {
        return true;
      }
    }
  }
  return false;
}

/// What Aravis would crash on, asked of libusb in the same words; empty: nothing.
std::string DangerOf(libusb_device* device) {
  libusb_config_descriptor* read = nullptr;
  const int failure = libusb_get_config_descriptor(device, 0, &read);
  if (failure != LIBUSB_SUCCESS) {
    return fmt::format("its configuration cannot be read, {}", libusb_error_name(failure));
  }
  const std::unique_ptr<libusb_config_descriptor, FreeConfiguration> configuration(read);
  return HasCameraInterfaceWithoutEndpoint(*configuration) ? "a camera's interface has no endpoint" : "";
}

}  // namespace

Result<void> CheckUsbBeforeAravis(const std::string& serial) {
  const Result<LibusbContext> context = OpenLibusb();
  if (!context) return serial.empty() ? Result<void>() : Fail(context.error());  // Aravis sees no devices either
  libusb_device** read = nullptr;
  const ssize_t count = libusb_get_device_list(context->get(), &read);
  if (count < 0) {
    return Fail(ErrorCode::kDevice, "USB: the devices cannot be listed: {}",
                libusb_error_name(static_cast<int>(count)));
  }
  const std::unique_ptr<libusb_device*, FreeList> list(read);
  for (libusb_device* device : std::span(read, static_cast<std::size_t>(count))) {
    const std::string danger = DangerOf(device);
    if (danger.empty()) continue;
    const std::string port_path = PortPathOf(device);
    const std::optional<UsbDevice> known = ReadUsbDevice(port_path);
    const std::string flaw = known ? CheckUsbDescriptors(known->descriptors).flaw : "";
    return Fail(ErrorCode::kDevice,
                "USB: the device at port {} has malformed descriptors ({}), no USB camera can be opened while it is "
                "plugged in",
                port_path, flaw.empty() ? danger : flaw);
  }
  if (serial.empty()) return {};
  for (const UsbDevice& device : ReadUsbDevices()) {
    const UsbDescriptorCheck check = CheckUsbDescriptors(device.descriptors);
    if (Trimmed(device.serial) == serial && check.says_usb3_vision && !check.flaw.empty()) {
      return Fail(ErrorCode::kDevice,
                  "USB: the camera with the serial number '{}' at port {} has malformed descriptors: {}", serial,
                  device.port_path, check.flaw);
    }
  }
  return {};
}

}  // namespace rigcal
