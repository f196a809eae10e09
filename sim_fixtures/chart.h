#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/rigid3.h"
#include "core/scene/board.h"
#include "core/scene/board_shape.h"
#include "sim_fixtures/mesh.h"

namespace rigcal::sim {

/// A board as printed. The cells are libapriltag's, whose home is core/seed: whoever makes a studio brings them.
struct ChartPrint {
  Board board;
  int edge_cells = 0;            ///< width of the square that Board::tag_m measures
  std::vector<cv::Mat1b> cells;  ///< per tag from first_id on: all of its cells, 255 is white, row 0 the upper one
};

/// A board that lies on the table in the place of the object.
struct ChartOptions {
  ChartPrint print;
  BoardShape shape;
  double tilt_deg = 0;    ///< a wedge lifts the upper edge by this angle
  int num_hand_held = 0;  ///< per camera: more pictures, of the board held by hand
};

/// How it lies: its middle near the axis, turned, and tilted as feet and tables are not even. It is lifted until
/// nothing of it is below the table top: z of its origin is Board::thickness_m for a flat board that lies flat, and up
/// to some tenths of a millimetre more otherwise.
Rigid3d PlaceChart(const ChartOptions& options, std::uint64_t random_seed);

/// The paper, with the white margin round the tags, in the flat print's frame.
Eigen::AlignedBox2d PaperInBoard(const ChartPrint& print);

/// The bent board as a body: the print above, board to Board::thickness_m below it. Chords are below 1 micrometre off
/// for a bow of 10 mm.
TriangleMesh ChartMesh(const ChartOptions& options, const Rigid3d& world_from_board);

/// What the board reflects at a place of its surface: ink or paper on the print, bare board elsewhere.
class ChartMaterial {
 public:
  ChartMaterial(const ChartOptions& options, const Rigid3d& world_from_board);
  /// The normal may have any length.
  [[nodiscard]] float ReflectanceAt(const Eigen::Vector3d& x_in_world, const Eigen::Vector3d& normal_in_world) const;

  static constexpr float kInk = 0.04f, kPaper = 0.85f;  ///< a laser print on office paper
  static constexpr float kBoard = 0.6f;                 ///< its edges and its back

 private:
  [[nodiscard]] bool IsInk(const Eigen::Vector2d& x_in_print) const;

  ChartPrint print_;
  Rigid3d board_from_world_;
  Eigen::Vector3d print_in_world_;           ///< the board's +z
  Eigen::Vector2d centre_, print_by_board_;  ///< undo the stretch about the centre
  double pitch_m_, cell_m_, outside_m_;      ///< outside: from a tag's square to the rim of its cells
};

}  // namespace rigcal::sim
