#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/driver.h"
#include "drivers/found_device.h"

namespace rigcal {

/// The devices of a rig, opened, in the order of the rig file.
struct OpenedRig {
  std::vector<std::unique_ptr<CameraDevice>> cameras;
  std::unique_ptr<PositionerDevice> positioner;  ///< none where stops are made by hand
  bool real = false;                             ///< some device is neither simulated nor replayed
};

/// Opens all devices of a rig. Errors: those of the drivers; kBadInput for a name that is none of a driver.
Result<OpenedRig> OpenRig(const RigHardware& rig, const DriverContext& context, const std::stop_token& stop);

/// What a look around found.
struct DeviceSearch {
  std::vector<FoundDevice> devices;    ///< cameras first, then positioners, each by driver and address
  std::vector<std::string> looked_at;  ///< "USB3 Vision cameras": where something was looked for
  std::vector<std::string> failures;   ///< sentences: where one could not look, and why
};

/// Looks for the devices of every driver, and at the addresses that the rig has. Nothing moves, and nobody loses
/// a device by it. Errors: kCancelled.
Result<DeviceSearch> FindDevices(const RigHardware& rig, Clock& clock, const std::stop_token& stop);

/// For each device of the rig that none of the found ones is: a sentence with its name, what the rig file says of it
/// and what was found instead. Devices that somebody else plays (arm, sim, replay) are never missing.
std::vector<std::string> MissingDevices(const RigHardware& rig, const std::vector<FoundDevice>& found);

/// The names that OpenRig knows.
std::vector<std::string> DriverNames();

}  // namespace rigcal
