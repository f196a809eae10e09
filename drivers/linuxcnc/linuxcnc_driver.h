#pragma once

#include <memory>

#include "drivers/driver.h"

namespace rigcal {

/// Machines behind LinuxCNC's linuxcncrsh (README.md). It has no cameras. Errors: none of its own.
Result<std::unique_ptr<Driver>> MakeLinuxcncDriver(const RigHardware& rig, const DriverContext& context,
                                                   const std::stop_token& stop);

}  // namespace rigcal
