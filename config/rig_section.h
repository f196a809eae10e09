#pragma once

#include <string>
#include <vector>

#include "config/json_content.h"
#include "core/geometry/camera.h"
#include "core/scene/rig_estimate.h"

namespace rigcal {

/// The key "rig" of a calibration.json: positioner, how exactly it repeats, where each camera is mounted, and their
/// covariance (docs/schema/calibration.schema.json).
nlohmann::ordered_json RigSectionJson(const RigEstimate& rig, const std::vector<Camera>& cameras);
/// Back; `cameras` are those of the file. Throws BadContent; `file` begins messages about poses.
RigEstimate RigSectionFrom(const nlohmann::ordered_json& json, const std::vector<Camera>& cameras,
                           const std::string& file);

}  // namespace rigcal
