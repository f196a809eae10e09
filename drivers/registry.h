#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/driver.h"

namespace rigcal {

/// The devices of a rig, opened, in the order of the rig file.
struct OpenedRig {
  std::vector<std::unique_ptr<CameraDevice>> cameras;
  std::unique_ptr<PositionerDevice> positioner;  ///< none where stops are made by hand
  bool real = false;                             ///< some device is neither simulated nor replayed
};

/// Opens all devices of a rig. Errors: those of the drivers; kBadInput for a name that is none of a driver.
Result<OpenedRig> OpenRig(const RigHardware& rig, const DriverContext& context, const std::stop_token& stop);

/// The names that OpenRig knows.
std::vector<std::string> DriverNames();

}  // namespace rigcal
