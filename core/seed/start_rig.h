#pragma once

#include "core/base/execution.h"
#include "core/seed/chart_state.h"

namespace rigcal {

/// Starting values of the rig from cam_from_board of the views at its stops: the positioner's geometry from the camera
/// that sees the chart at most stops, each camera's mount from the one of its views that agrees best with its others.
/// A camera that never sees the chart at a stop gets no mount. Errors: kBadInput when the stops do not determine the
/// positioner.
Result<void> StartRig(const ChartTerms& terms, const RigModel& prior, ChartState& state);

}  // namespace rigcal
