#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/descriptor.h"
#include "core/base/result.h"

namespace rigcal {

/// The few questions of the GigE Vision control protocol that are asked without opening a camera. Aravis asks them too,
/// but each of its waits lasts up to 3 s and cannot be stopped, and it takes the first network interface that gets an
/// answer for the one that pictures come in by.

/// What a camera says of itself.
struct GigeAnswer {
  std::string address;  ///< as it has it, which may be none of this network
  std::string vendor, model, firmware, serial;
};

/// Who controls a camera.
struct GigeHolder {
  std::string address;     ///< empty: it does not say
  bool exclusive = false;  ///< nobody else may even read
};

/// What a look for cameras reaches.
enum class GigeReach {
  kAllInterfaces,
  kThisMachine  ///< simulated cameras on 127/8
};

/// Every camera that answers within a second, or all until the one with this serial number has. Errors: kCancelled;
/// kDevice: no network interface can be asked through.
Result<std::vector<GigeAnswer>> FindGigeCameras(GigeReach reach, const std::optional<std::string>& serial, Clock& clock,
                                                const std::stop_token& stop);

/// What is at an IPv4 address; nothing when there is no answer within wait_s. Errors: kCancelled, kBadInput (no
/// address).
Result<std::optional<GigeAnswer>> AskGigeCamera(const std::string& address, double wait_s, Clock& clock,
                                                const std::stop_token& stop);

/// Who controls the camera at an address; nothing when nobody does. Errors: those of AskGigeCamera; kTimeout: no answer
/// within wait_s.
Result<std::optional<GigeHolder>> HolderOfGigeCamera(const std::string& address, double wait_s, Clock& clock,
                                                     const std::stop_token& stop);

/// The address of this machine that talks to an address: what its network routes say. Errors: kBadInput, kDevice.
Result<std::string> OwnAddressTowards(const std::string& address);

}  // namespace rigcal
