#pragma once

#include <optional>

#include "drivers/found_device.h"
#include "drivers/usb/usb_device.h"

namespace rigcal {

/// The USB3 Vision cameras that are plugged in, as drivers/genicam opens them. The address is the port path. Nothing is
/// opened. Problems: malformed descriptors; a USB3 camera on a USB2 port; a device node that this user may not open.
/// Errors: kCancelled.
Result<std::vector<FoundDevice>> FindUsbCameras(Clock& clock, const std::stop_token& stop);

/// The row of one device; nothing when it does not say that it is a USB3 Vision camera.
std::optional<FoundDevice> UsbCameraRow(const UsbDevice& device);

}  // namespace rigcal
