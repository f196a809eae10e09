#pragma once

#include <string>
#include <vector>

#include "config/rig_reader.h"
#include "core/scene/rig_devices.h"
#include "core/scene/rig_model.h"

namespace rigcal {

/// The axes of a turntable or gantry in the order of `axes`, or of their [[positioner.axis]] where `axes` is not there;
/// none for an arm. `driver` decides how a controller's letter may look. Errors: kBadInput: more axes than the kind
/// has, one that is not in `axes`, there twice or without a letter, limits the wrong way round, a backlash without an
/// approach.
Result<std::vector<AxisSettings>> ReadAxes(const CheckedTable& positioner, const std::vector<CheckedTable>& tables,
                                           PositionerKind kind, const std::string& driver);

}  // namespace rigcal
