#pragma once

#include <string>

#include "core/base/result.h"

namespace rigcal {

/// Whether Aravis may look at USB devices at all, and at the camera with this serial number (empty: at none). Aravis
/// 0.8.26 asks libusb for the first configuration of every device that it can open, takes it for granted that there is
/// one, and the program crashes where libusb could not read it, or where a camera's interface has no endpoint. So a
/// single device that would do that, camera or not, forbids all of them. To be called right before Aravis looks: a
/// device that is plugged in between the two is not seen. Errors: kDevice, naming the port and what is wrong there.
Result<void> CheckUsbBeforeAravis(const std::string& serial);

}  // namespace rigcal
