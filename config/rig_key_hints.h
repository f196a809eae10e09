#pragma once

#include <string>
#include <string_view>

#include "config/rig_keys.h"

namespace rigcal {

/// What to say of a key that a table does not have: "unknown in [[camera]]; did you mean exposure_us (microseconds)?",
/// whose it is when another kind of positioner or another table has it, else which keys are known.
std::string WhyUnknown(std::string_view name, const RigTable& table, std::string_view kind);

}  // namespace rigcal
