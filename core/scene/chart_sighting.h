#pragma once

#include <Eigen/Core>
#include <vector>

namespace rigcal {

/// A corner of a tag in the original (distorted) picture; pixel (0,0) is the centre of the top-left pixel.
struct ChartCorner {
  int tag_id = 0;
  int corner = 0;  ///< 0..3, see TagCornerInBoard
  Eigen::Vector2d x_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

/// What one view saw of the board; empty when it saw nothing.
struct ChartSighting {
  int view = 0;
  std::vector<ChartCorner> corners;
};

}  // namespace rigcal
