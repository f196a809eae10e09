#pragma once

#include <optional>

#include "core/scene/rig_estimate.h"

namespace rigcal {

/// A turntable's axis in the first camera that has a place in the rig. Nothing for another positioner, or without one.
std::optional<AxisEstimate> AxisOf(const RigEstimate& rig);

}  // namespace rigcal
