#pragma once

#include <memory>

#include "drivers/driver.h"
#include "drivers/sim/sim_rig.h"

namespace rigcal {

/// The simulated studio stands for the cameras and the turntable (README.md): the cameras of this driver are the
/// studio's, in their order. Errors: kBadInput for settings out of range or a chart that is not given;
/// kCancelled.
Result<std::unique_ptr<Driver>> MakeSimDriver(const RigHardware& rig, const DriverContext& context,
                                              const std::stop_token& stop);

/// The same, of devices whose faults the caller can set. Errors: those of MakeSimDriver.
Result<std::shared_ptr<SimRig>> MakeSimRig(const RigHardware& rig, const DriverContext& context,
                                           const std::stop_token& stop);
std::unique_ptr<Driver> DriverOf(std::shared_ptr<SimRig> sim, const RigHardware& rig);

}  // namespace rigcal
