#pragma once

#include <libusb.h>

#include <memory>
#include <string>

#include "core/base/result.h"

namespace rigcal {

struct CloseLibusb {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};
using LibusbContext = std::unique_ptr<libusb_context, CloseLibusb>;

/// Errors: kDevice (libusb cannot be used here, as on a machine without USB).
Result<LibusbContext> OpenLibusb();

/// The port path of a device, as the kernel names its folder: "1-2.3".
std::string PortPathOf(libusb_device* device);

}  // namespace rigcal
