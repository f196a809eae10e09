#pragma once

#include <vector>

#include "core/scene/board.h"
#include "core/scene/chart_sighting.h"

namespace rigcal {

/// Takes out corners that do not lie where a homography of the corners around them has them: a clip, a finger or a
/// reflection looked like a corner. The limit is kStrayDeviations of the picture's own median deviation, and no less
/// than kMinStrayPx. Gives how many were taken out.
int DropStrays(const Board& board, std::vector<ChartCorner>& corners);

/// Deviations of true corners (distortion, a bent board, noise) stay below four of their median, measured on
/// yac-aprilgrid.
inline constexpr double kStrayDeviations = 6;
inline constexpr double kMinStrayPx = 0.3;

}  // namespace rigcal
