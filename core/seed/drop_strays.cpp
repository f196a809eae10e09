#include "core/seed/drop_strays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <tuple>

#include "core/base/median.h"

namespace rigcal {
namespace {

constexpr std::size_t kNumAround = 24;  // six tags: enough to average noise, small enough for distortion
constexpr std::size_t kMinAround = 8;   // below, nothing can be said
constexpr int kMaxRounds = 4;           // a stray corner also disturbs those around it

// Distance of a corner from where the corners around it have it; 0 when they are too few.
double DeviationPx(const std::vector<Eigen::Vector2d>& on_board, const std::vector<ChartCorner>& corners,
                   std::size_t self) {
  std::vector<std::pair<double, std::size_t>> around;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (i != self) around.emplace_back((on_board[i] - on_board[self]).squaredNorm(), i);
  if (around.size() < kMinAround) return 0;
  const std::size_t count = std::min(kNumAround, around.size());
  std::partial_sort(around.begin(), around.begin() + count, around.end());
  std::vector<cv::Point2d> from, to;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d x = on_board[around[i].second] - on_board[self];
    from.emplace_back(x.x(), x.y());
    const Eigen::Vector2d& x_px = corners[around[i].second].x_px;
    to.emplace_back(x_px.x(), x_px.y());
  }
  const cv::Mat homography = cv::findHomography(from, to);
  if (homography.empty()) return 0;
  const cv::Matx33d h = homography;
  return (Eigen::Vector2d(h(0, 2), h(1, 2)) / h(2, 2) - corners[self].x_px).norm();
}

}  // namespace

int DropStrays(const Board& board, std::vector<ChartCorner>& corners) {
  int dropped = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<Eigen::Vector2d> on_board;
    for (const ChartCorner& corner : corners)
      on_board.emplace_back(TagCornerInBoard(board, corner.tag_id, corner.corner).head<2>() / board.tag_m);
    std::vector<double> deviations_px;
    for (std::size_t i = 0; i < corners.size(); ++i) deviations_px.push_back(DeviationPx(on_board, corners, i));
    const double limit_px = std::max(kMinStrayPx, kStrayDeviations * Median(deviations_px));
    std::vector<ChartCorner> kept;
    for (std::size_t i = 0; i < corners.size(); ++i)
      if (deviations_px[i] <= limit_px) kept.push_back(corners[i]);
    if (kept.size() == corners.size()) break;
    dropped += static_cast<int>(corners.size() - kept.size());
    corners = std::move(kept);
  }
  return dropped;
}

}  // namespace rigcal
