#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace rigcal {

/// What a device's descriptors say of it as a USB3 Vision camera.
struct UsbDescriptorCheck {
  /// It says that it is one: an interface or an interface association of class EF/05 was seen, or it is a device of
  /// class EF/02/01 whose descriptors break off before they say what it is.
  bool says_usb3_vision = false;
  /// What is wrong with it as such a camera: one sentence with offset in bytes, value and limit. Empty: nothing.
  std::string flaw;
  bool super_speed_able = false;  ///< made for 5 Gbit/s and more, whatever the port gave it (bmSpeedSupport)
};

/// Reads the device descriptor and the configurations that follow it, as the kernel has them in sysfs (`descriptors`),
/// and checks everything that Aravis 0.8.26 takes as given in the first configuration: total length, every length,
/// interface association, control and stream interface with their endpoints, device information. Reads nothing beyond
/// `bytes`. Source: USB 3.2 chapter 9.6; USB3 Vision's
/// device information descriptor.
UsbDescriptorCheck CheckUsbDescriptors(std::span<const std::uint8_t> bytes);

}  // namespace rigcal
