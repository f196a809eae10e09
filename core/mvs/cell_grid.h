#pragma once

#include <cstdint>
#include <vector>

#include "core/mvs/build_patch.h"

namespace rigcal::stereo {

/// A view divided into cells of zeta x zeta pixels of the level.
struct CellLayout {
  int cell_px, columns, rows;

  CellLayout(const StereoView& view, int cell_px);
  [[nodiscard]] std::size_t NumCells() const { return IndexOf(0, rows); }
  [[nodiscard]] std::size_t IndexOf(int column, int row) const {
    return static_cast<std::size_t>(row * columns + column);
  }
  /// Of a pixel that lies in the image.
  [[nodiscard]] int ColumnAt(const Eigen::Vector2d& x_px) const { return static_cast<int>(x_px.x() + 0.5) / cell_px; }
  [[nodiscard]] int RowAt(const Eigen::Vector2d& x_px) const { return static_cast<int>(x_px.y() + 0.5) / cell_px; }
  [[nodiscard]] std::size_t CellAt(const Eigen::Vector2d& x_px) const { return IndexOf(ColumnAt(x_px), RowAt(x_px)); }
};

/// The cells of all views (zeta x zeta pixels of the level each): which hold a patch, which are being worked on, and
/// how often each was tried in vain.
class CellGrid {
 public:
  explicit CellGrid(const StereoScene& scene);

  /// Index of the cell at a pixel; the pixel lies in the image.
  [[nodiscard]] std::size_t CellAt(int view, const Eigen::Vector2d& x_px) const { return layouts_[view].CellAt(x_px); }
  /// Pixel that stands for the cell, or -1 when `column`, `row` lie outside.
  struct CellPixel {
    int u_px, v_px;
    std::size_t index;
  };
  /// The cell `columns` to the right and `rows` below the one at a pixel; nothing outside the image.
  [[nodiscard]] std::optional<CellPixel> Neighbour(int view, const Eigen::Vector2d& x_px, int columns, int rows) const;

  [[nodiscard]] bool IsFilled(int view, std::size_t cell) const { return cells_[view][cell] & kFilled; }
  [[nodiscard]] bool IsPending(int view, std::size_t cell) const { return cells_[view][cell] & kPending; }
  [[nodiscard]] int Attempts(int view, std::size_t cell) const { return cells_[view][cell] >> kAttemptShift; }
  struct CellOfView {
    int view;
    std::size_t cell;
  };
  void SetPending(const CellOfView& cell);
  void ClearPending();
  void CountAttempt(int view, std::size_t cell);
  /// Marks the cells of all sightings.
  void Fill(const SurfacePatch& patch);
  void ClearFilled();

 private:
  static constexpr std::uint8_t kFilled = 1, kPending = 2, kAttemptShift = 2;
  std::vector<CellLayout> layouts_;
  std::vector<std::vector<std::uint8_t>> cells_;
  std::vector<CellOfView> pending_;
};

/// The same in all views: patches by cell, for looking up neighbours. Immutable.
class CellIndex {
 public:
  /// Incomplete when stopped: whoever goes on with it asks the stop token.
  CellIndex(const StereoScene& scene, const std::vector<SurfacePatch>& patches, const Execution& execution);

  struct Entry {
    int patch;
    float depth;                ///< in the view
    Eigen::Vector2f centre_px;  ///< projection of the patch's centre, without the sighting's offset
    Eigen::Vector3f normal_in_world;
  };

  /// Calls visit(Entry) for the patches in the cells within `reach` of the one at a pixel.
  template <typename Visit>
  void ForNeighbours(int view, const Eigen::Vector2d& x_px, int reach, Visit visit) const {
    const Cells& cells = views_[view];
    const CellLayout& layout = cells.layout;
    const int c = layout.ColumnAt(x_px), r = layout.RowAt(x_px);
    for (int row = std::max(0, r - reach); row <= std::min(layout.rows - 1, r + reach); ++row) {
      for (int column = std::max(0, c - reach); column <= std::min(layout.columns - 1, c + reach); ++column) {
        const std::size_t cell = layout.IndexOf(column, row);
        for (int i = cells.first[cell]; i < cells.first[cell + 1]; ++i) visit(cells.entries[i]);
      }
    }
  }

 private:
  struct Cells {
    CellLayout layout;
    std::vector<int> first;  ///< of each cell in entries; one more at the end
    std::vector<Entry> entries;
  };
  void EnterPatches(const std::vector<SurfacePatch>& patches, int from_view, int to_view);
  std::vector<Cells> views_;
};

}  // namespace rigcal::stereo
