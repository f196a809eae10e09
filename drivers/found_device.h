#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/result.h"

namespace rigcal {

enum class DeviceKind { kCamera, kPositioner };

/// A device that answered when it was looked for, as `rigcal devices` lists it. Texts are empty where the device does
/// not say.
struct FoundDevice {
  std::string driver;  ///< as a rig file names it
  DeviceKind kind = DeviceKind::kCamera;
  std::string address;  ///< as a rig file has it: IP address, port path, serial line, host:port
  std::string serial;
  std::string model, firmware;
  std::string state;    ///< "free", "held by 10.0.0.7", "alarm 1 (hard limit)"
  std::string problem;  ///< what is wrong with it, a sentence; empty: nothing
};

/// One driver's look around: opens nothing for longer than it takes to ask, moves nothing, and takes no device from
/// whoever holds it. Errors: kCancelled; kDevice when it could not look at all, with the reason.
using FindDevicesOfDriver = Result<std::vector<FoundDevice>> (*)(Clock& clock, const std::stop_token& stop);

}  // namespace rigcal
