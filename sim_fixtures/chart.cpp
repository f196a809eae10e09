#include "sim_fixtures/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr std::uint64_t kPlaceTask = 20;      ///< DeriveSeed: how the board lies
constexpr double kOffset_m = 0.004;           ///< of its middle from the axis: laid down by eye
constexpr double kTurn_rad = 8 * kRadPerDeg;  ///< largest, from the world's x axis
constexpr double kUnevenSigma_deg = 0.2;      ///< about each of two axes: 1 mm under one foot
constexpr int kGridCells = 128;               ///< across the paper, in both directions
constexpr double kLeastBody_m = 0.0005;       ///< of a print without a board: it is seen from one side only

/// White ring, data outside of the square (reversed borders), or squares in the gaps' corners (Kalibr).
double PrintedOutside_m(const ChartPrint& print) {
  const double ring_m = 0.5 * (print.cells.front().rows - print.edge_cells) * print.board.tag_m / print.edge_cells;
  return print.board.border_bits > 1 ? std::max(print.board.gap_m, ring_m) : ring_m;
}

/// The bent paper as a grid of kGridCells^2 squares.
class Sheet {
 public:
  Sheet(const ChartOptions& options, const Rigid3d& world_from_board)
      : options_(options), world_from_board_(world_from_board), paper_(PaperInBoard(options.print)) {}

  /// `depth_m` below the print.
  [[nodiscard]] Vector3d InWorld(int column, int row, double depth_m) const {
    return world_from_board_ * (Bent(Flat(column, row)) - Vector3d(0, 0, depth_m));
  }

  /// By central differences, which are exact for the shape's parabolas.
  [[nodiscard]] Vector3d NormalInWorld(int column, int row) const {
    constexpr double kStep_m = 1e-3;
    const Vector3d x = Flat(column, row), dx(kStep_m, 0, 0), dy(0, kStep_m, 0);
    return world_from_board_.rotation * (Bent(x + dx) - Bent(x - dx)).cross(Bent(x + dy) - Bent(x - dy)).normalized();
  }

 private:
  [[nodiscard]] Vector3d Flat(int column, int row) const {
    const Vector2d share = Vector2d(column, row) / kGridCells;
    const Vector2d x = paper_.min() + share.cwiseProduct(paper_.sizes());
    return {x.x(), x.y(), 0};
  }
  [[nodiscard]] Vector3d Bent(const Vector3d& x_in_print) const {
    return OnBoard(options_.print.board, options_.shape, x_in_print);
  }

  const ChartOptions& options_;
  Rigid3d world_from_board_;
  Eigen::AlignedBox2d paper_;
};

std::uint32_t Add(TriangleMesh& mesh, const Vector3d& x_in_world, const Vector3d& normal_in_world) {
  mesh.vertices_in_world.push_back(x_in_world.cast<float>());
  mesh.normals_in_world.push_back(normal_in_world.cast<float>());
  return static_cast<std::uint32_t>(mesh.vertices_in_world.size() - 1);
}

void AddQuad(TriangleMesh& mesh, const std::array<std::uint32_t, 4>& corners) {
  mesh.triangles.push_back({corners[0], corners[1], corners[2]});
  mesh.triangles.push_back({corners[0], corners[2], corners[3]});
}

void AddSheet(const Sheet& sheet, double depth_m, bool faces_up, TriangleMesh& mesh) {
  constexpr std::uint32_t kAcross = kGridCells + 1;
  const auto first = static_cast<std::uint32_t>(mesh.vertices_in_world.size());
  for (int row = 0; row <= kGridCells; ++row) {
    for (int column = 0; column <= kGridCells; ++column) {
      const Vector3d up = sheet.NormalInWorld(column, row);
      Add(mesh, sheet.InWorld(column, row, depth_m), faces_up ? up : Vector3d(-up));
    }
  }
  for (std::uint32_t row = 0; row < kGridCells; ++row) {
    for (std::uint32_t column = 0; column < kGridCells; ++column) {
      const std::uint32_t a = first + row * kAcross + column, b = a + 1, c = b + kAcross, d = a + kAcross;
      AddQuad(mesh, faces_up ? std::array{a, b, c, d} : std::array{a, d, c, b});
    }
  }
}

/// The four edges, each from one corner of the paper counter-clockwise to the next.
void AddEdges(const Sheet& sheet, double body_m, const Rigid3d& world_from_board, TriangleMesh& mesh) {
  constexpr std::array<std::array<int, 2>, 5> kCorners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}};
  for (int side = 0; side < 4; ++side) {
    const auto &from = kCorners[side], &to = kCorners[side + 1];
    const Vector3d outward =
        world_from_board.rotation * Vector3d(to[1] - from[1], from[0] - to[0], 0);  // on the right of the way
    for (int i = 0; i < kGridCells; ++i) {
      const auto at = [&](int step, double depth_m) {
        const int column = from[0] * kGridCells + (to[0] - from[0]) * step;
        const int row = from[1] * kGridCells + (to[1] - from[1]) * step;
        return Add(mesh, sheet.InWorld(column, row, depth_m), outward);
      };
      AddQuad(mesh, {at(i, body_m), at(i + 1, body_m), at(i + 1, 0), at(i, 0)});
    }
  }
}

}  // namespace

Eigen::AlignedBox2d PaperInBoard(const ChartPrint& print) {
  const double cell_m = print.board.tag_m / print.edge_cells;
  const bool white_ring_only = print.board.border_bits == 1 && print.cells.front().rows == print.edge_cells + 2;
  const double margin_m = PrintedOutside_m(print) + (white_ring_only ? 0 : cell_m);
  const Vector2d size = 2 * CentreInBoard(print.board).head<2>();
  return {Vector2d::Constant(-margin_m), size + Vector2d::Constant(margin_m)};
}

Rigid3d PlaceChart(const ChartOptions& options, std::uint64_t random_seed) {
  Random random(DeriveSeed(random_seed, kPlaceTask));
  const Vector3d offset(random.Uniform(-kOffset_m, kOffset_m), random.Uniform(-kOffset_m, kOffset_m), 0);
  const double turn_rad = random.Uniform(-kTurn_rad, kTurn_rad);
  const double about_x_deg = kUnevenSigma_deg * random.Normal(), about_y_deg = kUnevenSigma_deg * random.Normal();
  Rigid3d place;
  place.rotation = ExpRotation({0, 0, turn_rad}) *
                   ExpRotation({(options.tilt_deg + about_x_deg) * kRadPerDeg, about_y_deg * kRadPerDeg, 0});
  place.translation = offset - place.rotation * CentreInBoard(options.print.board);
  place.translation.z() = options.print.board.thickness_m;
  const Sheet sheet(options, place);
  double lowest_m = 0;
  for (int row = 0; row <= kGridCells; ++row) {
    for (int column = 0; column <= kGridCells; ++column) {
      lowest_m = std::min(lowest_m, sheet.InWorld(column, row, options.print.board.thickness_m).z());
    }
  }
  place.translation.z() -= lowest_m;
  return place;
}

TriangleMesh ChartMesh(const ChartOptions& options, const Rigid3d& world_from_board) {
  const Sheet sheet(options, world_from_board);
  const double body_m = std::max(options.print.board.thickness_m, kLeastBody_m);
  TriangleMesh mesh;
  AddSheet(sheet, 0, true, mesh);
  AddSheet(sheet, body_m, false, mesh);
  AddEdges(sheet, body_m, world_from_board, mesh);
  return mesh;
}

ChartMaterial::ChartMaterial(const ChartOptions& options, const Rigid3d& world_from_board)
    : print_(options.print),
      board_from_world_(world_from_board.Inverse()),
      print_in_world_(world_from_board.rotation * Vector3d::UnitZ()),
      centre_(CentreInBoard(print_.board).head<2>()) {
  Ensure(static_cast<int>(print_.cells.size()) == print_.board.NumTags(), "every tag of the board has its cells");
  const Vector3d corner = CentreInBoard(print_.board) + Vector3d(1, 1, 0);
  const Vector2d stretched = (OnBoard(print_.board, options.shape, corner).head<2>() - centre_);
  print_by_board_ = stretched.cwiseInverse();
  pitch_m_ = print_.board.tag_m + print_.board.gap_m;
  cell_m_ = print_.board.tag_m / print_.edge_cells;
  outside_m_ = 0.5 * (print_.cells.front().rows - print_.edge_cells) * cell_m_;
}

float ChartMaterial::ReflectanceAt(const Vector3d& x_in_world, const Vector3d& normal_in_world) const {
  constexpr double kLeastCosine = 0.5;  // between the print (bent by a few degrees) and the edges (at right angles)
  if (normal_in_world.dot(print_in_world_) < kLeastCosine * normal_in_world.norm()) return kBoard;
  const Vector2d x_in_board = (board_from_world_ * x_in_world).head<2>();
  return IsInk(centre_ + (x_in_board - centre_).cwiseProduct(print_by_board_)) ? kInk : kPaper;
}

bool ChartMaterial::IsInk(const Vector2d& x) const {
  const Board& board = print_.board;
  // The tag that is nearest, with half of the gap round it.
  const auto nearest = [&](double along_m, int count) {
    return std::clamp(static_cast<int>(std::floor((along_m + 0.5 * board.gap_m) / pitch_m_)), 0, count - 1);
  };
  const int column = nearest(x.x(), board.columns), row = nearest(x.y(), board.rows);
  const cv::Mat1b& cells = print_.cells[row * board.columns + column];
  const int u = static_cast<int>(std::floor((x.x() - column * pitch_m_ + outside_m_) / cell_m_));
  const int v = cells.rows - 1 - static_cast<int>(std::floor((x.y() - row * pitch_m_ + outside_m_) / cell_m_));
  if (u >= 0 && v >= 0 && u < cells.cols && v < cells.rows && cells(v, u) == 0) return true;
  if (board.border_bits == 1) return false;
  // Kalibr's squares, left of and below every tag, and once more beyond the last column and row.
  const auto in_gap = [&](double along_m, int count) {
    const double steps = std::floor((along_m + board.gap_m) / pitch_m_);
    return steps >= 0 && steps <= count && along_m + board.gap_m - steps * pitch_m_ < board.gap_m;
  };
  return in_gap(x.x(), board.columns) && in_gap(x.y(), board.rows);
}

}  // namespace rigcal::sim
