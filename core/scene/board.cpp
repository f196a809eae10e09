#include "core/scene/board.h"

#include "core/base/ensure.h"

namespace rigcal {

Eigen::Vector3d TagCornerInBoard(const Board& board, int id, int corner) {
  Ensure(board.HasTag(id), "the board has no tag of this id");
  Ensure(corner >= 0 && corner < kCornersPerTag, "a tag has four corners");
  const int column = (id - board.first_id) % board.columns;
  const int row = (id - board.first_id) / board.columns;
  const double pitch_m = board.tag_m + board.gap_m;
  const bool right = corner == 1 || corner == 2;
  const bool upper = corner >= 2;
  return {column * pitch_m + (right ? board.tag_m : 0), row * pitch_m + (upper ? board.tag_m : 0), 0};
}

}  // namespace rigcal
