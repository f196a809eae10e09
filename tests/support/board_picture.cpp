#include "tests/support/board_picture.h"

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal {
namespace {

// A Fibonacci lattice: an edge along the pixel grid is placed to 1/89 of a pixel too, where a grid of 8 x 8 rays would
// be off by up to 1/16.
constexpr int kNumRays = 89;
constexpr int kRayStep = 55;

// Light from a point of the board's plane.
double LightAt(const BoardPrint& print, const BoardPictureOptions& options, double x_m, double y_m) {
  const Board& board = print.board;
  const double pitch_m = board.tag_m + board.gap_m;
  const double width_m = board.columns * pitch_m, height_m = board.rows * pitch_m;
  if (x_m < -2 * board.gap_m || y_m < -2 * board.gap_m || x_m > width_m + board.gap_m || y_m > height_m + board.gap_m)
    return options.ground;
  const double cell_m = board.tag_m / print.edge_cells;
  const int total = print.cells[0].rows;
  const double outside_m = (total - print.edge_cells) / 2 * cell_m;
  const int column = static_cast<int>(std::floor((x_m + outside_m) / pitch_m));
  const int row = static_cast<int>(std::floor((y_m + outside_m) / pitch_m));
  if (column >= 0 && row >= 0 && column < board.columns && row < board.rows) {
    const int u = static_cast<int>(std::floor((x_m - column * pitch_m + outside_m) / cell_m));
    const int v = total - 1 - static_cast<int>(std::floor((y_m - row * pitch_m + outside_m) / cell_m));
    if (u >= 0 && v >= 0 && u < total && v < total && print.cells[row * board.columns + column](v, u) == 0)
      return options.black;
  }
  const double x_in_pitch_m = x_m + board.gap_m, y_in_pitch_m = y_m + board.gap_m;  // gaps left of and below the tags
  if (print.corner_squares && x_m <= width_m && y_m <= height_m && x_in_pitch_m >= 0 && y_in_pitch_m >= 0 &&
      std::fmod(x_in_pitch_m, pitch_m) < board.gap_m && std::fmod(y_in_pitch_m, pitch_m) < board.gap_m)
    return options.black;
  return options.white;
}

// Point of the board's plane that is seen at a pixel; far away where it is not seen.
Eigen::Vector2d BoardPoint(const Camera& camera, const Rigid3d& board_from_cam, const Eigen::Vector2d& x_px) {
  const std::optional<Eigen::Vector3d> ray = RayInCam(camera, x_px);
  const Eigen::Vector3d origin = board_from_cam.translation;
  const Eigen::Vector3d direction = ray ? Eigen::Vector3d(board_from_cam.rotation * *ray) : Eigen::Vector3d(0, 0, 1);
  if (direction.z() * origin.z() >= 0) return {1e9, 1e9};
  return (origin - direction * (origin.z() / direction.z())).head<2>();
}

float Encoded(double light) {
  return static_cast<float>(light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

}  // namespace

Eigen::Vector2d TrueCornerPx(const Board& board, const Camera& camera, const Rigid3d& cam_from_board, int id,
                             int corner) {
  const auto x_px = Project(camera, cam_from_board * TagCornerInBoard(board, id, corner));
  Ensure(x_px.has_value(), "the board is in front of the camera");
  return *x_px;
}

cv::Mat1f RenderBoard(const BoardPrint& print, const Camera& camera, const Rigid3d& cam_from_board,
                      const BoardPictureOptions& options) {
  const Rigid3d board_from_cam = cam_from_board.Inverse();
  const int across = camera.width_px + 1;
  std::vector<Eigen::Vector2d> corners_m;  // of the pixels, on the board
  for (int row = 0; row <= camera.height_px; ++row)
    for (int column = 0; column <= camera.width_px; ++column)
      corners_m.push_back(BoardPoint(camera, board_from_cam, Eigen::Vector2d(column - 0.5, row - 0.5)));
  cv::Mat1f picture(camera.height_px, camera.width_px);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      // Within a pixel the map to the board is affine to better than 1e-3 of a pixel.
      const Eigen::Vector2d* upper = &corners_m[row * across + column];
      const Eigen::Vector2d* lower = upper + across;
      const Eigen::Vector2d middle = (upper[0] + upper[1] + lower[0] + lower[1]) / 4;
      const Eigen::Vector2d by_x = (upper[1] - upper[0] + lower[1] - lower[0]) / 2;
      const Eigen::Vector2d by_y = (lower[0] - upper[0] + lower[1] - upper[1]) / 2;
      double sum = 0;
      for (int i = 0; i < kNumRays; ++i) {
        const double a = (i + 0.5) / kNumRays - 0.5, b = (i * kRayStep % kNumRays + 0.5) / kNumRays - 0.5;
        const Eigen::Vector2d x_m = middle + a * by_x + b * by_y;
        sum += LightAt(print, options, x_m.x(), x_m.y());
      }
      picture(row, column) = static_cast<float>(sum / kNumRays);
    }
  }
  if (options.blur_px > 0) cv::GaussianBlur(picture, picture, {0, 0}, options.blur_px);
  Random random(options.random_seed);
  for (float& value : picture) {
    if (!options.linear) value = Encoded(value);
    if (options.noise > 0) value += static_cast<float>(options.noise * random.Normal());
  }
  return picture;
}

}  // namespace rigcal
