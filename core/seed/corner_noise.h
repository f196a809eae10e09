#pragma once

#include <vector>

#include "core/seed/chart_problem.h"

namespace rigcal {

/// Length of every corner's residual, per view: in pixels, and in the sigmas that its detector stated. Infinite for a
/// corner that is not in front of the camera.
struct CornerResiduals {
  std::vector<std::vector<double>> px, stated_sigmas;
};
CornerResiduals ResidualsOf(const ChartTerms& terms, const ChartState& state);

/// Sigma over stated sigma of a set of residual lengths, by their median; 0 without any.
double RobustScale(const std::vector<double>& stated_sigmas);

/// Noise scale of each camera before the fit can be trusted: that of the lower quartile of its views, so that views the
/// model does not fit have no say.
std::vector<double> RobustScales(const ChartTerms& terms, const CornerResiduals& residuals);

/// Noise scale of each camera from its weighted squared residuals over their degrees of freedom.
std::vector<double> FittedScales(const ChartTerms& terms, const ChartLinearisation& fit);

/// Takes out the corners that are grossly wrong for their camera and for their view; returns how many per camera.
std::vector<int> DropGrossCorners(const CornerResiduals& residuals, int num_cameras, ChartTerms& terms);

}  // namespace rigcal
