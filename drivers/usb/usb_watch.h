#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "core/base/clock.h"
#include "drivers/usb/libusb_context.h"

namespace rigcal {

/// A USB3 Vision camera was plugged in or is gone.
struct UsbEvent {
  bool arrived = false;
  std::string port_path;  ///< "1-2.3"
  std::string serial;     ///< empty where it does not say
};

/// Sees cameras come and go from the moment of Start. Used by one thread: everything happens in Next, nothing is called
/// from elsewhere. A camera whose descriptors libusb cannot read at all never arrives here; FindUsbCameras lists it.
class UsbWatch {
 public:
  static constexpr double kSlice_s = 0.1;  ///< between two looks at the clock and the stop token

  /// The clock outlives it. Errors: kDevice (no USB), kUnsupported (a libusb without hot-plug).
  static Result<std::unique_ptr<UsbWatch>> Start(Clock& clock);
  ~UsbWatch();
  UsbWatch(const UsbWatch&) = delete;
  UsbWatch& operator=(const UsbWatch&) = delete;

  /// The next event; nothing when timeout_s have passed without one (0: looks once). Errors: kCancelled; kDevice.
  Result<std::optional<UsbEvent>> Next(double timeout_s, const std::stop_token& stop);

 private:
  UsbWatch(LibusbContext context, Clock& clock) : context_(std::move(context)), clock_(clock) {}
  static int LIBUSB_CALL OnChange(libusb_context* context, libusb_device* device, libusb_hotplug_event event,
                                  void* watch) noexcept;
  void Note(bool arrived, const std::string& port_path);

  LibusbContext context_;
  Clock& clock_;
  libusb_hotplug_callback_handle handle_ = 0;
  std::map<std::string, std::string> serials_;  ///< of the cameras that are plugged in, by port path
  std::deque<UsbEvent> events_;
};

}  // namespace rigcal
