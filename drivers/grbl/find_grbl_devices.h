#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/found_device.h"

namespace rigcal {

/// The serial lines of this machine that a board can be on: /dev/serial/by-id/..., and of ttyUSB and ttyACM those that
/// are not there. Sorted.
std::vector<std::string> SerialLinesPresent();

/// The board on one serial line: it is asked for its state and version, which moves and resets nothing (a board that is
/// reset by the opening of its line, as many are, starts anew). A line that is held by another program is a row, too,
/// and is not asked. Nothing where no GRBL answers. Errors: kCancelled; those of SerialLine::Open.
Result<std::optional<FoundDevice>> FindGrblDeviceAt(const std::string& line, Clock& clock, const std::stop_token& stop);

/// The boards on all of SerialLinesPresent. Errors: see FindDevicesOfDriver.
Result<std::vector<FoundDevice>> FindGrblDevices(Clock& clock, const std::stop_token& stop);

}  // namespace rigcal
