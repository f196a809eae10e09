#include "core/scene/board_shape.h"

namespace rigcal {

Eigen::Vector3d CentreInBoard(const Board& board) {
  const double pitch_m = board.tag_m + board.gap_m;
  return {0.5 * (board.columns * pitch_m - board.gap_m), 0.5 * (board.rows * pitch_m - board.gap_m), 0};
}

Eigen::Vector3d OnBoard(const Board& board, const BoardShape& shape, const Eigen::Vector3d& x_in_print,
                        Eigen::Matrix3d* by_shape) {
  constexpr double kMeanSquare = 1.0 / 3;  // of a number spread evenly over [-1, 1]
  const Eigen::Vector3d centre = CentreInBoard(board);
  const Eigen::Vector3d d = x_in_print - centre;
  const double u = d.x() / centre.x(), v = d.y() / centre.y();
  const double by_bow_x = u * u - kMeanSquare, by_bow_y = v * v - kMeanSquare;
  if (by_shape != nullptr) {
    *by_shape << 0, 0, 0.5 * d.x(), 0, 0, -0.5 * d.y(), by_bow_x, by_bow_y, 0;
  }
  return x_in_print + Eigen::Vector3d(0.5 * shape.stretch * d.x(), -0.5 * shape.stretch * d.y(),
                                      shape.bow_x_m * by_bow_x + shape.bow_y_m * by_bow_y);
}

Eigen::Vector3d TagCornerInBoard(const Board& board, const BoardShape& shape, int id, int corner,
                                 Eigen::Matrix3d* by_shape) {
  return OnBoard(board, shape, TagCornerInBoard(board, id, corner), by_shape);
}

}  // namespace rigcal
