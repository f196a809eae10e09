#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <tuple>

#include "core/base/joined.h"
#include "drivers/genicam/genicam_driver.h"
#include "drivers/grbl/find_grbl_devices.h"
#include "drivers/linuxcnc/find_linuxcnc_devices.h"
#include "drivers/registry.h"
#include "drivers/usb/find_usb_cameras.h"

namespace rigcal {
namespace {

/// One look around; sim, replay and arm have no devices to be found.
struct FindDevicesOf {
  std::string_view what;
  FindDevicesOfDriver find;
};

constexpr std::array kSearches = {
    FindDevicesOf{"GigE Vision cameras on the networks of this machine", FindGenicamDevices},
    FindDevicesOf{"USB3 Vision cameras", FindUsbCameras},
    FindDevicesOf{"LinuxCNC at 127.0.0.1:5007", FindLinuxcncDevices},
    FindDevicesOf{"GRBL on the serial lines by-id, ttyUSB and ttyACM", FindGrblDevices},
};

/// A device at an address that a rig file has.
struct FindDeviceOf {
  std::string_view driver;
  Result<std::optional<FoundDevice>> (*find)(const std::string& address, Clock& clock, const std::stop_token& stop);
};

constexpr std::array kAtAddress = {
    FindDeviceOf{"genicam", FindGenicamDeviceAt},
    FindDeviceOf{"linuxcnc", FindLinuxcncDeviceAt},
    FindDeviceOf{"grbl", FindGrblDeviceAt},
};

/// Whether two addresses are one device's: names of one serial line are.
bool SameAddress(const std::string& a, const std::string& b) {
  if (a == b) return true;
  if (!a.starts_with('/') || !b.starts_with('/')) return false;
  // Not std::filesystem::equivalent: it gives false for devices.
  std::error_code none;
  return std::filesystem::weakly_canonical(a, none) == std::filesystem::weakly_canonical(b, none);
}

bool IsOf(const FoundDevice& device, const std::string& driver, const std::string& address) {
  return device.driver == driver && SameAddress(device.address, address);
}

/// Reports an Error that does not end the search.
Result<void> Note(const Error& error, DeviceSearch& search) {
  if (error.code == ErrorCode::kCancelled) return Fail(error);
  search.failures.push_back(error.message);
  return {};
}

Result<void> FindAtAddress(const std::string& driver, const std::string& address, DeviceSearch& search, Clock& clock,
                           const std::stop_token& stop) {
  const auto at = std::ranges::find(kAtAddress, driver, &FindDeviceOf::driver);
  if (at == kAtAddress.end() || address.empty()) return {};
  const bool known =
      std::ranges::any_of(search.devices, [&](const FoundDevice& device) { return IsOf(device, driver, address); });
  if (known) return {};
  search.looked_at.push_back(fmt::format("{} at {}", driver, address));
  Result<std::optional<FoundDevice>> device = at->find(address, clock, stop);
  if (!device) return Note(device.error(), search);
  if (*device) search.devices.push_back(std::move(**device));
  return {};
}

/// "; found: A, B", or that there is none.
std::string Others(const std::vector<std::string>& found, const char* none) {
  return found.empty() ? fmt::format("; {}", none) : fmt::format("; found: {}", Joined(found, ", "));
}

}  // namespace

Result<DeviceSearch> FindDevices(const RigHardware& rig, Clock& clock, const std::stop_token& stop) {
  DeviceSearch search;
  for (const FindDevicesOf& look : kSearches) {
    search.looked_at.emplace_back(look.what);
    Result<std::vector<FoundDevice>> found = look.find(clock, stop);
    if (found) {
      std::ranges::move(*found, std::back_inserter(search.devices));
    } else if (Result<void> noted = Note(found.error(), search); !noted) {
      return Fail(noted.error());
    }
  }
  std::vector<std::pair<std::string, std::string>> addresses = {{rig.positioner.driver, rig.positioner.address}};
  for (const CameraSettings& camera : rig.cameras) addresses.emplace_back(camera.driver, camera.address);
  for (const auto& [driver, address] : addresses) {
    if (Result<void> found = FindAtAddress(driver, address, search, clock, stop); !found) return Fail(found.error());
  }
  std::ranges::sort(search.devices, {}, [](const FoundDevice& device) {
    return std::tuple(device.kind, device.driver, device.address, device.serial);
  });
  return search;
}

std::vector<std::string> MissingDevices(const RigHardware& rig, const std::vector<FoundDevice>& found) {
  std::vector<std::string> missing, cameras, positioners;
  for (const FoundDevice& device : found) {
    if (device.kind == DeviceKind::kPositioner) {
      positioners.push_back(fmt::format("{} at {}", device.driver, device.address));
    } else {
      cameras.push_back(device.serial.empty() ? device.address : device.serial);
    }
  }
  for (const CameraSettings& camera : rig.cameras) {
    if (camera.driver != "genicam") continue;
    const bool there = std::ranges::any_of(found, [&](const FoundDevice& device) {
      if (device.kind != DeviceKind::kCamera || device.driver != camera.driver) return false;
      return camera.serial.empty() ? device.address == camera.address : device.serial == camera.serial;
    });
    if (there) continue;
    const std::string by = camera.serial.empty() ? "address " + camera.address : "serial number " + camera.serial;
    missing.push_back(fmt::format("camera '{}': no camera with the {} is found{}", camera.id, by,
                                  Others(cameras, "no camera is found")));
  }
  const PositionerSettings& positioner = rig.positioner;
  const bool sought = std::ranges::find(kAtAddress, positioner.driver, &FindDeviceOf::driver) != kAtAddress.end();
  const bool there = std::ranges::any_of(
      found, [&](const FoundDevice& device) { return IsOf(device, positioner.driver, positioner.address); });
  if (!sought || there) return missing;
  missing.push_back(fmt::format("positioner: no {} is found at {}{}", positioner.driver, positioner.address,
                                Others(positioners, "no positioner is found")));
  return missing;
}

}  // namespace rigcal
