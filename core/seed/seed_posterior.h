#pragma once

#include "core/seed/chart_problem.h"
#include "core/seed/seed_cameras.h"

namespace rigcal {

/// Fills calibration (with covariance), view_of, hand_held, board_shape and rig of the result from the solution.
/// `covariance`: of everything estimated, by columns.
void WriteSolution(const SeedScene& scene, const ChartTerms& terms, const ChartState& state,
                   const ChartColumns& columns, const Eigen::MatrixXd& covariance, SeedResult& result);

}  // namespace rigcal
