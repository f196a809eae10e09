#pragma once

#include <vector>

#include "config/rig_reader.h"
#include "core/scene/rig_devices.h"

namespace rigcal {

/// [stops]: one value per axis (radians or metres), in the file's order. Errors: kBadInput: an arm's, both ways of
/// saying it or neither, not one value for each axis, a stop twice, a stop that an axis reaches only beyond its soft
/// limits, the way round its backlash included.
Result<std::vector<std::vector<double>>> ReadStops(const CheckedTable& table, const std::vector<AxisSettings>& axes);

}  // namespace rigcal
