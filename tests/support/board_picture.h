#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/rigid3.h"
#include "core/scene/board.h"

namespace rigcal {

/// A flat board as printed: `cells` holds, for each tag from first_id on, its squares (0 black, 255 white), row 0 the
/// upper one; the detected square of the tag lies `cells.size() / 2` around the middle as `edge_cells` say.
struct BoardPrint {
  Board board;
  int edge_cells = 8;
  std::vector<cv::Mat1b> cells;
  bool corner_squares = false;  ///< black squares that fill the corners of the gaps, as Kalibr prints them
};

struct BoardPictureOptions {
  double blur_px = 0.5;                            ///< Gaussian, on light
  double noise = 0;                                ///< standard deviation, of values in [0, 1], after encoding
  bool linear = true;                              ///< values proportional to light; otherwise sRGB
  double white = 0.8, black = 0.03, ground = 0.2;  ///< light from paper, ink and what lies around the board
  std::uint64_t random_seed = 1;
};

/// What the camera sees of the board: every pixel is the mean of 89 rays, through its lens's distortion.
cv::Mat1f RenderBoard(const BoardPrint& print, const Camera& camera, const Rigid3d& cam_from_board,
                      const BoardPictureOptions& options);

/// Where the camera sees a corner of a tag.
Eigen::Vector2d TrueCornerPx(const Board& board, const Camera& camera, const Rigid3d& cam_from_board, int id,
                             int corner);

}  // namespace rigcal
