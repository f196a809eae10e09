#pragma once

#include "core/seed/chart_state.h"

namespace rigcal {

/// RobustScale of a view's corners had the view the pose that fits them best (to first order about the pose of the
/// state): what is left of its residuals is its corners' fault, not that of the pose.
double ScaleWithOwnPose(const ChartTerms& terms, const ChartState& state, int view);

}  // namespace rigcal
