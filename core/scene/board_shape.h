#pragma once

#include <Eigen/Core>

#include "core/scene/board.h"

namespace rigcal {

/// How a real board differs from the flat one of its file. Its overall size is the unit of length and has no error.
///   x = x_flat + stretch / 2 (x_flat - x_c),  y = y_flat - stretch / 2 (y_flat - y_c)
///   z = bow_x (u^2 - 1/3) + bow_y (v^2 - 1/3),  u, v: x, y of the flat board from -1 to 1 over the tags
struct BoardShape {
  double bow_x_m = 0;  ///< height of the board's left and right edge over its middle
  double bow_y_m = 0;  ///< height of its lower and upper edge over its middle
  double stretch = 0;  ///< print scale along x over that along y, minus one
};
inline constexpr int kBoardShapeSize = 3;

/// Where a point of the flat print (z = 0) is on the real board, and its derivative by bow_x_m, bow_y_m, stretch. The
/// margin round the tags bends with them.
Eigen::Vector3d OnBoard(const Board& board, const BoardShape& shape, const Eigen::Vector3d& x_in_print,
                        Eigen::Matrix3d* by_shape = nullptr);

/// TagCornerInBoard of the real board, and its derivative as of OnBoard.
Eigen::Vector3d TagCornerInBoard(const Board& board, const BoardShape& shape, int id, int corner,
                                 Eigen::Matrix3d* by_shape = nullptr);

/// Middle of the flat board's tags.
Eigen::Vector3d CentreInBoard(const Board& board);

}  // namespace rigcal
