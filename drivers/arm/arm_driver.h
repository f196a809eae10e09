#pragma once

#include <memory>

#include "drivers/driver.h"

namespace rigcal {

/// An arm that somebody else moves (README.md). Its address is HOST:PORT to listen on, or a file of poses. Where it
/// listens is told (DriverContext::tell). Errors of its positioner: those of ProgrammedArm and ListedArm.
Result<std::unique_ptr<Driver>> MakeArmDriver(const RigHardware& rig, const DriverContext& context,
                                              const std::stop_token& stop);

}  // namespace rigcal
