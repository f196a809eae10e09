#pragma once

#include <memory>
#include <vector>

#include "drivers/driver.h"
#include "drivers/found_device.h"
#include "drivers/genicam/genicam_options.h"

namespace rigcal {

/// GenICam cameras on a network (GigE Vision) and at USB (USB3 Vision), through Aravis (README.md). It moves nothing.
/// Errors: none of its own.
Result<std::unique_ptr<Driver>> MakeGenicamDriver(const RigHardware& rig, const DriverContext& context,
                                                  const std::stop_token& stop);
/// The same with other waits.
std::unique_ptr<Driver> MakeGenicamDriver(const GenicamOptions& options, const DriverContext& context);

/// Every GigE Vision camera that answers, and who controls it; every USB3 Vision camera that is plugged in. Errors: see
/// FindDevicesOfDriver.
Result<std::vector<FoundDevice>> FindGenicamDevices(Clock& clock, const std::stop_token& stop);
/// The GigE Vision cameras alone, within reach.
Result<std::vector<FoundDevice>> FindGenicamDevices(GigeReach reach, Clock& clock, const std::stop_token& stop);
/// The camera at an IPv4 address, which may lie beyond a router, where nobody hears a broadcast; nothing where none
/// answers. Errors: kCancelled, kBadInput (no address).
Result<std::optional<FoundDevice>> FindGenicamDeviceAt(const std::string& address, Clock& clock,
                                                       const std::stop_token& stop);

}  // namespace rigcal
