#pragma once

#include <string>

#include "core/base/result.h"
#include "core/scene/rig_devices.h"
#include "drivers/genicam/gobject_pointer.h"

namespace rigcal {

/// What a camera is after it was set.
struct CameraFacts {
  int width_px = 0, height_px = 0;
  std::size_t payload_bytes = 0;  ///< of one frame
  bool linear = true;             ///< its gamma is off
  bool has_clock = false;         ///< its frames tell when they were taken, and it can be asked for the time
};

/// Sets an opened camera as the rig file says: what it does not mention stays. Acquisition is continuous, each picture
/// on a trigger. Errors: kBadInput, naming camera, key, value and what the camera allows; kUnsupported (it has no such
/// setting); kDevice (it refuses).
Result<CameraFacts> SetUpCamera(ArvCamera* camera, const CameraSettings& settings);

}  // namespace rigcal
