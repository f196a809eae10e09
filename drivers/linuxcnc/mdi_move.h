#pragma once

#include <string>
#include <vector>

#include "core/scene/rig_devices.h"
#include "drivers/linuxcnc/rsh_session.h"

namespace rigcal {

/// LinuxCNC's units: degrees of an axis that turns, millimetres of one that does not.
double RshFromAxis(double value, AxisUnit unit);
double AxisFromRsh(double value, AxisUnit unit);

/// The line of G-code for a straight move from where the machine stands, in machine coordinates, so that neither work
/// nor tool offsets count. `to` has a value for each axis of the settings, in the settings' units. The axes keep their
/// speeds: the slowest tells how long it takes; at the controller's own speed (G0) where none of those that move has
/// one.
std::string MdiMove(const RshPosition& from, const std::vector<double>& to, const std::vector<AxisSettings>& axes);

}  // namespace rigcal
