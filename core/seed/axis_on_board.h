#pragma once

#include <Eigen/Core>

#include "core/seed/chart_state.h"
#include "core/seed/seed_cameras.h"

namespace rigcal {

/// Where a turntable's axis goes through the board that lies on it. `covariance`: 4 x 4, of the place.
AxisOnBoard AxisOnBoardOf(const BoardPlace& place, double thickness_m, const Eigen::Matrix4d& covariance);

/// d (direction_in_board, point_in_board) / d place: 5 x kBoardPlaceSize.
Eigen::Matrix<double, 5, kBoardPlaceSize> AxisOnBoardByPlace(const BoardPlace& place, double thickness_m);

}  // namespace rigcal
