#include "drivers/genicam/usb_link.h"

#include <unistd.h>

#include <regex>
#include <utility>
#include <vector>

#include "core/base/joined.h"
#include "drivers/usb/check_usb_before_aravis.h"
#include "drivers/usb/check_usb_descriptors.h"
#include "drivers/usb/usb_device.h"

namespace rigcal {
namespace {

constexpr guint64 kVersionRegister = 0;  ///< of GenCP: every camera has it, whatever it is doing

bool IsPortPath(const std::string& address) {
  static const std::regex kPortPath("[0-9]+-[0-9]+(\\.[0-9]+)*");
  return std::regex_match(address, kPortPath);
}

std::vector<UsbDevice> PluggedInCameras() {
  std::vector<UsbDevice> devices = ReadUsbDevices();
  std::erase_if(devices,
                [](const UsbDevice& device) { return !CheckUsbDescriptors(device.descriptors).says_usb3_vision; });
  return devices;
}

/// The camera that the settings mean. Errors: kNotFound, kBadInput.
Result<UsbDevice> Locate(const CameraSettings& settings) {
  std::vector<UsbDevice> meant;
  std::vector<std::string> others;
  for (UsbDevice& device : PluggedInCameras()) {
    const bool is_meant = (settings.address.empty() || device.port_path == settings.address) &&
                          (settings.serial.empty() || Trimmed(device.serial) == settings.serial);
    if (!is_meant) others.push_back(fmt::format("'{}' at port {}", Trimmed(device.serial), device.port_path));
    if (is_meant) meant.push_back(std::move(device));
  }
  if (meant.empty()) {
    return Fail(ErrorCode::kNotFound, "camera '{}': none with {} '{}' is plugged in at USB, found: {}", settings.id,
                settings.serial.empty() ? "the port" : "the serial number",
                settings.serial.empty() ? settings.address : settings.serial,
                others.empty() ? "none" : Joined(others, ", "));
  }
  if (meant.size() > 1) {
    return Fail(ErrorCode::kBadInput, "camera '{}': two cameras have the serial number '{}', at ports {} and {}",
                settings.id, settings.serial, meant[0].port_path, meant[1].port_path);
  }
  return std::move(meant[0]);
}

}  // namespace

bool UsbLink::Means(const CameraSettings& settings) {
  if (!settings.address.empty()) return IsPortPath(settings.address);
  for (const UsbDevice& device : PluggedInCameras()) {
    if (Trimmed(device.serial) == settings.serial) return true;
  }
  return false;
}

Result<std::unique_ptr<CameraLink>> UsbLink::Open(const CameraSettings& settings) {
  const Result<UsbDevice> device = Locate(settings);
  if (!device) return Fail(device.error());
  if (Result<void> may = CheckUsbBeforeAravis(Trimmed(device->serial)); !may) {
    return Fail(may.error().code, "camera '{}': {}", settings.id, may.error().message);
  }
  if (access(device->node.c_str(), R_OK | W_OK) != 0) {
    return Fail(ErrorCode::kDevice,
                "camera '{}' at port {}: this user may not open {} (a udev rule gives the right to)", settings.id,
                device->port_path, device->node);
  }
  GLibError error;
  const GObjectPointer<ArvDevice> opened(
      arv_uv_device_new(device->vendor.c_str(), device->model.c_str(), device->serial.c_str(), error.Take()));
  GObjectPointer<ArvCamera> camera(opened ? arv_camera_new_with_device(opened.get(), error.Take()) : nullptr);
  if (!camera) {
    return Fail(ErrorCode::kDevice, "camera '{}' at port {}: {}: {}", settings.id, device->port_path,
                device->held ? "is held by another program" : "cannot be opened", error.Text());
  }
  AnnouncedCamera announced{.address = device->port_path,
                            .vendor = Trimmed(device->vendor),
                            .model = Trimmed(device->model),
                            .serial = Trimmed(device->serial)};
  return std::unique_ptr<CameraLink>(new UsbLink(settings.id, std::move(announced), std::move(camera)));
}

Result<void> UsbLink::Check(const std::stop_token& stop) const {
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "camera '{}': was stopped on request", Id());
  if (ControlLost()) {
    return Fail(ErrorCode::kDevice, "camera '{}': was unplugged from port {}", Id(), Announced().address);
  }
  GLibError error;
  guint32 version = 0;
  if (arv_device_read_register(arv_camera_get_device(Camera()), kVersionRegister, &version, error.Take()) == FALSE) {
    return Fail(ErrorCode::kDevice, "camera '{}': does not answer at port {} any more: {}", Id(), Announced().address,
                error.Text());
  }
  return {};
}

}  // namespace rigcal
