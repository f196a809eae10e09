#pragma once

#include <memory>

#include "drivers/driver.h"

namespace rigcal {

/// GRBL 1.1 controllers on serial devices (README.md). It has no cameras. Errors: none of its own.
Result<std::unique_ptr<Driver>> MakeGrblDriver(const RigHardware& rig, const DriverContext& context,
                                               const std::stop_token& stop);

}  // namespace rigcal
