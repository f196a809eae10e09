#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace rigcal {

/// Where the kernel lists the USB devices that are plugged in, one folder each, named by its port path.
inline constexpr const char* kUsbDeviceFolder = "/sys/bus/usb/devices";

/// A USB device as the kernel knows it since it was plugged in; nothing is asked of the device itself. Texts are empty
/// where it does not say, and as libusb gives them to Aravis: every character beyond ASCII is a '?'.
struct UsbDevice {
  std::string port_path;                  ///< bus and ports on the way to it: "1-2.3"
  std::string vendor, model, serial;      ///< some end with spaces: see Trimmed
  std::string firmware;                   ///< bcdDevice, "1.10"
  double speed_mbit_per_s = 0;            ///< that the port gave it: 480, 5000, 10000; 0: unknown
  std::string node;                       ///< "/dev/bus/usb/001/002"
  bool held = false;                      ///< a program has taken one of its interfaces
  std::vector<std::uint8_t> descriptors;  ///< as CheckUsbDescriptors takes them
};

/// One of them; nothing when there is none at that port.
std::optional<UsbDevice> ReadUsbDevice(const std::string& port_path, const std::string& folder = kUsbDeviceFolder);

/// All of them, hubs among them, in the order of their port paths; none where there is no USB.
std::vector<UsbDevice> ReadUsbDevices(const std::string& folder = kUsbDeviceFolder);

/// Without the spaces that some devices fill their texts with.
std::string Trimmed(std::string text);

}  // namespace rigcal
