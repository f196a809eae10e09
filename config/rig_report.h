#pragma once

#include <string>
#include <vector>

#include "config/json_content.h"
#include "core/scene/rig_estimate.h"

namespace rigcal {

/// The key "rig" of a report.json: the axis and each stop's errors, with sigmas. `camera_ids`: of the calibration.
nlohmann::ordered_json RigFitJson(const RigFit& fit, const std::vector<std::string>& camera_ids);

/// A line about the axis, for people.
std::string AxisText(const AxisEstimate& axis, const std::vector<std::string>& camera_ids);

}  // namespace rigcal
