#pragma once

#include <Eigen/Geometry>
#include <numbers>

#include "core/seed/tag_family.h"
#include "tests/support/board_picture.h"

namespace rigcal {

inline BoardPrint PrintOf(const Board& board) {
  const Result<TagFamily> family = TagFamily::Make(board.family, board.border_bits);
  BoardPrint print{board, family->EdgeCells(), {}, board.border_bits > 1};
  for (int id = board.first_id; id < board.first_id + board.NumTags(); ++id) print.cells.push_back(family->Cells(id));
  return print;
}

/// Own board: 4 x 3 tags of 30 mm.
inline Board StockBoard() {
  return {.columns = 4, .rows = 3, .tag_m = 0.03, .gap_m = 0.009};
}

inline Board KalibrBoard() {
  return {.border_bits = 2, .columns = 4, .rows = 3, .tag_m = 0.03, .gap_m = 0.009};
}

inline Camera TestCamera() {
  return {.id = "test",
          .width_px = 400,
          .height_px = 320,
          .fx_px = 520,
          .fy_px = 521,
          .cx_px = 203,
          .cy_px = 158,
          .k1 = -0.15,
          .k2 = 0.05,
          .p1 = 0.0005};
}

/// Looks at the middle of the board from `distance_m`, tilted and turned by angles in radians.
inline Rigid3d LookAt(const Board& board, double tilt_x, double tilt_y, double turn, double distance_m) {
  const double pitch_m = board.tag_m + board.gap_m;
  const Eigen::Vector3d middle((board.columns * pitch_m - board.gap_m) / 2, (board.rows * pitch_m - board.gap_m) / 2,
                               0);
  Rigid3d cam_from_board;
  // The board's y points up and its z to the camera: half a turn about x.
  cam_from_board.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(std::numbers::pi + tilt_x, Eigen::Vector3d::UnitX()) *
                            Eigen::AngleAxisd(tilt_y, Eigen::Vector3d::UnitY());
  cam_from_board.translation = Eigen::Vector3d(0, 0, distance_m) - cam_from_board.rotation * middle;
  return cam_from_board;
}

}  // namespace rigcal
