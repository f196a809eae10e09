#include "core/seed/corner_noise.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/median.h"

namespace rigcal {
namespace {

/// Median length of a 2-D normal vector of unit sigma: sqrt(2 ln 2).
constexpr double kMedianOfRayleigh = 1.1774100225;
/// A corner this many robust sigmas off is wrong, not noisy (one in 10^8 good ones).
constexpr double kGrossErrorSigmas = 6;
/// No camera sees corners more exactly than this many of the stated sigmas; keeps noiseless input finite.
constexpr double kLeastScale = 1e-4;

}  // namespace

CornerResiduals ResidualsOf(const ChartTerms& terms, const ChartState& state) {
  CornerResiduals out;
  for (int v = 0; v < static_cast<int>(terms.views.size()); ++v) {
    const ChartView& view = terms.views[v];
    auto& px = out.px.emplace_back();
    auto& sigmas = out.stated_sigmas.emplace_back();
    if (view.corners.empty()) continue;
    const Rigid3d cam_from_board = CamFromBoard(terms, state, v);
    for (const ChartCorner& corner : view.corners) {
      const auto seen =
          Project(state.cameras[view.camera],
                  cam_from_board * TagCornerInBoard(terms.board, state.shape, corner.tag_id, corner.corner));
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      const Eigen::Vector2d error_px = seen ? Eigen::Vector2d(*seen - corner.x_px) : Eigen::Vector2d::Zero();
      px.push_back(seen ? error_px.norm() : kInfinity);
      sigmas.push_back(seen ? std::sqrt(error_px.dot(corner.covariance_px2.llt().solve(error_px))) : kInfinity);
    }
  }
  return out;
}

double RobustScale(const std::vector<double>& stated_sigmas) {
  return Median(stated_sigmas) / kMedianOfRayleigh;
}

std::vector<double> RobustScales(const ChartTerms& terms, const CornerResiduals& residuals) {
  std::vector<std::vector<double>> of_views(terms.noise_scale.size());
  for (std::size_t v = 0; v < terms.views.size(); ++v) {
    if (terms.views[v].corners.empty()) continue;
    of_views[terms.views[v].camera].push_back(RobustScale(residuals.stated_sigmas[v]));
  }
  std::vector<double> scales;
  for (auto& views : of_views) {
    std::sort(views.begin(), views.end());
    scales.push_back(views.empty() ? 1.0 : std::max(kLeastScale, views[views.size() / 4]));
  }
  return scales;
}

std::vector<double> FittedScales(const ChartTerms& terms, const ChartLinearisation& fit) {
  std::vector<double> sum2(terms.noise_scale.size(), 0.0), scales;
  for (std::size_t v = 0; v < terms.views.size(); ++v) {
    const int first = fit.row_of_view[v];
    for (int row = first; row < first + 2 * static_cast<int>(terms.views[v].corners.size()); ++row) {
      sum2[terms.views[v].camera] += fit.row_weight[row] * fit.residuals[row] * fit.residuals[row];
    }
  }
  for (std::size_t c = 0; c < sum2.size(); ++c) {
    const double found = std::sqrt(sum2[c] / std::max(1.0, fit.degrees_of_freedom[c]));
    scales.push_back(std::max(kLeastScale, found * terms.noise_scale[c]));
  }
  return scales;
}

std::vector<int> DropGrossCorners(const CornerResiduals& residuals, int num_cameras, ChartTerms& terms) {
  std::vector<int> dropped(num_cameras, 0);
  for (std::size_t v = 0; v < terms.views.size(); ++v) {
    ChartView& view = terms.views[v];
    const std::vector<double>& sigmas = residuals.stated_sigmas[v];
    const double limit = kGrossErrorSigmas * std::max(terms.noise_scale[view.camera], RobustScale(sigmas));
    std::vector<ChartCorner> kept;
    for (std::size_t i = 0; i < view.corners.size(); ++i) {
      if (sigmas[i] <= limit) kept.push_back(view.corners[i]);
    }
    dropped[view.camera] += static_cast<int>(view.corners.size() - kept.size());
    view.corners = std::move(kept);
  }
  return dropped;
}

}  // namespace rigcal
