#pragma once

#include <memory>

#include "drivers/driver.h"

namespace rigcal {

/// A recording stands for the cameras and the positioner (README.md). Errors: kBadInput (the rig names no recording,
/// or one with pictures that belong to no stop), those of DriverContext::open_recording.
Result<std::unique_ptr<Driver>> MakeReplayDriver(const RigHardware& rig, const DriverContext& context,
                                                 const std::stop_token& stop);

}  // namespace rigcal
