#pragma once

#include <string>
#include <vector>

#include "core/seed/chart_problem.h"
#include "core/seed/seed_cameras.h"

namespace rigcal {

/// Fills coverage and max_tilt_rad of every camera's report.
void ReportCoverage(const SeedScene& scene, const ChartTerms& terms, const ChartState& state, SeedReport& report);

/// What to show next, one sentence for each camera that lacks something: parts of the picture without corners, a board
/// that was never tilted, few views, a focal length that is still uncertain, a camera that never saw the rig's stops.
std::vector<std::string> Advise(const SeedScene& scene, const ChartTerms& terms, const ChartState& state,
                                const ChartColumns& columns, const Eigen::MatrixXd& covariance,
                                const SeedReport& report);

}  // namespace rigcal
