#pragma once

#include <vector>

#include "core/scene/rig_model.h"
#include "sim_fixtures/studio.h"

namespace rigcal::sim {

/// How every stop of a turntable differs from what was commanded. Step, wobble and run-out have random numbers of their
/// own: one option leaves what the others draw as it is. The first stop has no step error, it is the zero of the
/// table's angle. Slips come on top.
std::vector<StopError> DrawStopErrors(const StudioOptions& options);

/// Where the table stands at a stop: MotionAt of core/rig, which this library may not link (tests/sim compares them).
Rigid3d StageFromWorld(double commanded_rad, const StopError& error);

}  // namespace rigcal::sim
