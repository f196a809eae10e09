#include "drivers/usb/find_usb_cameras.h"

#include <unistd.h>

#include <cerrno>

#include "core/base/joined.h"
#include "drivers/usb/check_usb_descriptors.h"

namespace rigcal {
namespace {

constexpr double kSuperSpeed_mbit_per_s = 5000;  ///< USB 3.2 Gen 1

/// Everything that keeps it from being used as it should.
std::string ProblemsOf(const UsbDevice& device, const UsbDescriptorCheck& check) {
  std::vector<std::string> problems;
  if (!check.flaw.empty()) {
    problems.push_back(fmt::format("its USB descriptors are malformed ({}): it is not opened", check.flaw));
  }
  if (check.super_speed_able && device.speed_mbit_per_s > 0 && device.speed_mbit_per_s < kSuperSpeed_mbit_per_s) {
    problems.push_back(fmt::format("a USB3 camera on a USB2 port or cable: {:.0f} instead of {:.0f} Mbit/s",
                                   device.speed_mbit_per_s, kSuperSpeed_mbit_per_s));
  }
  if (access(device.node.c_str(), R_OK | W_OK) != 0 && errno == EACCES) {
    problems.push_back(fmt::format("this user may not open {} (a udev rule gives the right to)", device.node));
  }
  return Joined(problems, "; ");
}

}  // namespace

std::optional<FoundDevice> UsbCameraRow(const UsbDevice& device) {
  const UsbDescriptorCheck check = CheckUsbDescriptors(device.descriptors);
  if (!check.says_usb3_vision) return std::nullopt;
  return FoundDevice{
      .driver = "genicam",
      .kind = DeviceKind::kCamera,
      .address = device.port_path,
      .serial = Trimmed(device.serial),
      .model = Trimmed(device.vendor.empty() ? device.model : Trimmed(device.vendor) + " " + device.model),
      .firmware = device.firmware,
      .state = device.held ? "held by a program on this machine" : "free",
      .problem = ProblemsOf(device, check)};
}

Result<std::vector<FoundDevice>> FindUsbCameras(Clock& /*clock*/, const std::stop_token& stop) {
  std::vector<FoundDevice> cameras;
  for (const UsbDevice& device : ReadUsbDevices()) {
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "USB: looking for cameras was stopped on request");
    if (std::optional<FoundDevice> row = UsbCameraRow(device)) cameras.push_back(std::move(*row));
  }
  return cameras;
}

}  // namespace rigcal
