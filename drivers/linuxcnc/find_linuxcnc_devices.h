#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/found_device.h"

namespace rigcal {

/// Where linuxcncrsh listens unless it is told otherwise.
inline constexpr const char* kUsualRshAddress = "127.0.0.1:5007";

/// The machine behind linuxcncrsh at HOST:PORT: it is asked for its state; control is not taken. Nothing where none
/// answers. Errors: kCancelled; kBadInput: an address that is none.
Result<std::optional<FoundDevice>> FindLinuxcncDeviceAt(const std::string& address, Clock& clock,
                                                        const std::stop_token& stop);

/// The one at kUsualRshAddress. Errors: see FindDevicesOfDriver.
Result<std::vector<FoundDevice>> FindLinuxcncDevices(Clock& clock, const std::stop_token& stop);

}  // namespace rigcal
