#pragma once

#include <string>

#include "config/rig_file.h"

namespace rigcal {

/// What the rig is, for people: a line for each of positioner, axes, stops, cameras and the rest, as far as there are
/// any. The same rig gives the same lines.
std::string RigSummaryText(const RigFile& rig);

}  // namespace rigcal
