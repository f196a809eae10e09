#include "core/seed/own_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "core/base/median.h"
#include "core/rig/reprojection.h"
#include "core/seed/corner_noise.h"

namespace rigcal {
namespace {

constexpr int kRobustIterations = 5;

/// A corner's residual in its stated sigmas, and how it follows the view's pose (Disturbed()).
struct PosedCorner {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 6> by_pose;
};

std::vector<PosedCorner> PosedCorners(const ChartTerms& terms, const ChartState& state, int view) {
  std::vector<PosedCorner> corners;
  const ChartView& seen_view = terms.views[view];
  const Rigid3d cam_from_board = CamFromBoard(terms, state, view);
  for (const ChartCorner& corner : seen_view.corners) {
    const auto seen = Reproject(state.cameras[seen_view.camera], cam_from_board,
                                TagCornerInBoard(terms.board, state.shape, corner.tag_id, corner.corner));
    if (!seen) continue;
    const Eigen::LLT<Eigen::Matrix2d> covariance(corner.covariance_px2);
    corners.push_back(
        {covariance.matrixL().solve(seen->x_px - corner.x_px), covariance.matrixL().solve(seen->by_pose)});
  }
  return corners;
}

}  // namespace

double ScaleWithOwnPose(const ChartTerms& terms, const ChartState& state, int view) {
  const std::vector<PosedCorner> corners = PosedCorners(terms, state, view);
  std::vector<double> left(corners.size());
  Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
  for (int iteration = 0; iteration <= kRobustIterations; ++iteration) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      left[i] = (corners[i].residual + corners[i].by_pose * delta).norm();
    }
    const double scale = Median(left);
    if (!(scale > 0)) return 0;
    Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double weight = 1 / (1 + left[i] * left[i] / (scale * scale));
      hessian += weight * corners[i].by_pose.transpose() * corners[i].by_pose;
      gradient += weight * corners[i].by_pose.transpose() * corners[i].residual;
    }
    delta = -hessian.ldlt().solve(gradient);
  }
  return RobustScale(left);
}

}  // namespace rigcal
