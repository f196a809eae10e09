#include "drivers/usb/usb_watch.h"

#include <sys/time.h>

#include <algorithm>
#include <cmath>

#include "drivers/usb/check_usb_descriptors.h"
#include "drivers/usb/usb_device.h"

namespace rigcal {
namespace {

timeval TimevalOf(double seconds) {
  constexpr double kMicro = 1e6;
  return {.tv_sec = static_cast<time_t>(seconds),
          .tv_usec = static_cast<suseconds_t>((seconds - std::floor(seconds)) * kMicro)};
}

}  // namespace

Result<std::unique_ptr<UsbWatch>> UsbWatch::Start(Clock& clock) {
  Result<LibusbContext> context = OpenLibusb();
  if (!context) return Fail(context.error());
  if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) == 0) {
    return Fail(ErrorCode::kUnsupported, "USB: this libusb does not tell when devices come and go");
  }
  std::unique_ptr<UsbWatch> watch(new UsbWatch(std::move(*context), clock));
  const int failure = libusb_hotplug_register_callback(
      watch->context_.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT,
      LIBUSB_HOTPLUG_ENUMERATE, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY, OnChange,
      watch.get(), &watch->handle_);
  if (failure != LIBUSB_SUCCESS) {
    return Fail(ErrorCode::kDevice, "USB: devices that come and go cannot be watched: {}", libusb_error_name(failure));
  }
  watch->events_.clear();  // those that were here before
  return watch;
}

UsbWatch::~UsbWatch() {
  libusb_hotplug_deregister_callback(context_.get(), handle_);
}

int UsbWatch::OnChange(libusb_context* /*context*/, libusb_device* device, libusb_hotplug_event event,
                       void* watch) noexcept {
  static_cast<UsbWatch*>(watch)->Note(event == LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, PortPathOf(device));
  return 0;  // goes on
}

void UsbWatch::Note(bool arrived, const std::string& port_path) {
  if (arrived) {
    const std::optional<UsbDevice> device = ReadUsbDevice(port_path);
    if (!device || !CheckUsbDescriptors(device->descriptors).says_usb3_vision) return;
    const std::string& serial = serials_[port_path] = Trimmed(device->serial);
    events_.push_back({.arrived = true, .port_path = port_path, .serial = serial});
  } else if (const auto known = serials_.extract(port_path)) {
    events_.push_back({.arrived = false, .port_path = port_path, .serial = known.mapped()});
  }
}

Result<std::optional<UsbEvent>> UsbWatch::Next(double timeout_s, const std::stop_token& stop) {
  const double end_s = clock_.NowS() + timeout_s;
  double left_s = timeout_s;
  do {
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "USB: watching was stopped on request");
    timeval slice = TimevalOf(events_.empty() ? std::clamp(left_s, 0.0, kSlice_s) : 0);
    const int failure = libusb_handle_events_timeout_completed(context_.get(), &slice, nullptr);
    if (failure != LIBUSB_SUCCESS && failure != LIBUSB_ERROR_INTERRUPTED) {
      return Fail(ErrorCode::kDevice, "USB: devices that come and go cannot be watched any more: {}",
                  libusb_error_name(failure));
    }
    left_s = end_s - clock_.NowS();
  } while (events_.empty() && left_s > 0);
  if (events_.empty()) return std::nullopt;
  UsbEvent event = std::move(events_.front());
  events_.pop_front();
  return event;
}

}  // namespace rigcal
