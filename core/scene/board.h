#pragma once

#include <Eigen/Core>
#include <string>

namespace rigcal {

/// A printed board of AprilTags in a grid: rigcal's own boards and Kalibr's AprilGrids (border_bits = 2).
/// Frame `board`: origin at the outer lower left corner of the lower left tag as one looks at the print, +x to the
/// right, +y up, +z towards who looks at it; metres. Ids count from first_id at the lower left, row by row upwards.
struct Board {
  std::string family = "tag36h11";
  int border_bits = 1;  ///< width of a tag's black border in bits: 1 as printed by libapriltag, 2 as by Kalibr
  int columns = 0;
  int rows = 0;
  double tag_m = 0;  ///< outer edge of a tag's black square
  double gap_m = 0;  ///< between the black squares of neighbours
  int first_id = 0;
  double thickness_m = 0;  ///< print to table top, for a board that lies on the table

  [[nodiscard]] int NumTags() const { return columns * rows; }
  [[nodiscard]] bool HasTag(int id) const { return id >= first_id && id < first_id + NumTags(); }
};

inline constexpr int kCornersPerTag = 4;

/// Corner 0..3 of the black square of tag `id`: lower left, lower right, upper right, upper left. z = 0: the flat
/// board.
Eigen::Vector3d TagCornerInBoard(const Board& board, int id, int corner);

}  // namespace rigcal
