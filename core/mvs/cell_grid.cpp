#include "core/mvs/cell_grid.h"

#include <algorithm>
#include <numeric>

namespace rigcal::stereo {

CellLayout::CellLayout(const StereoView& view, int side_px)
    : cell_px(side_px),
      columns((view.texels.cols + side_px - 1) / side_px),
      rows((view.texels.rows + side_px - 1) / side_px) {}

CellGrid::CellGrid(const StereoScene& scene) {
  for (const StereoView& view : scene.views) {
    layouts_.emplace_back(view, scene.options.cell_px);
    cells_.emplace_back(layouts_.back().NumCells(), std::uint8_t{0});
  }
}

std::optional<CellGrid::CellPixel> CellGrid::Neighbour(int view, const Eigen::Vector2d& x_px, int columns,
                                                       int rows) const {
  const CellLayout& layout = layouts_[view];
  const int column = layout.ColumnAt(x_px) + columns, row = layout.RowAt(x_px) + rows;
  if (column < 0 || row < 0 || column >= layout.columns || row >= layout.rows) return std::nullopt;
  const int middle_px = (layout.cell_px - 1) / 2;
  return CellPixel{column * layout.cell_px + middle_px, row * layout.cell_px + middle_px, layout.IndexOf(column, row)};
}

void CellGrid::SetPending(const CellOfView& cell) {
  cells_[cell.view][cell.cell] |= kPending;
  pending_.push_back(cell);
}

void CellGrid::ClearPending() {
  for (const auto& [view, cell] : pending_) cells_[view][cell] &= static_cast<std::uint8_t>(~kPending);
  pending_.clear();
}

void CellGrid::CountAttempt(int view, std::size_t cell) {
  constexpr std::uint8_t kOne = 1U << kAttemptShift;
  std::uint8_t& state = cells_[view][cell];
  if (state < UINT8_MAX - kOne) state = static_cast<std::uint8_t>(state + kOne);
}

void CellGrid::Fill(const SurfacePatch& patch) {
  for (std::size_t i = 0; i < patch.sightings.size(); ++i) {
    const int view = patch.sightings[i].view;
    cells_[view][CellAt(view, patch.pixels[i].x_px)] |= kFilled;
  }
}

void CellGrid::ClearFilled() {
  for (auto& view : cells_) {
    for (std::uint8_t& state : view) state &= static_cast<std::uint8_t>(~kFilled);
  }
}

CellIndex::CellIndex(const StereoScene& scene, const std::vector<SurfacePatch>& patches, const Execution& execution) {
  for (const StereoView& view : scene.views) {
    const CellLayout layout(view, scene.options.cell_px);
    views_.push_back({layout, std::vector<int>(layout.NumCells() + 1), {}});
  }
  // Each thread goes through all patches, for views of its own.
  const int num_views = static_cast<int>(views_.size()), num_shares = std::clamp(execution.num_threads, 1, num_views);
  const auto enter_share = [&](int share) {
    const int from = num_views * share / num_shares, to = num_views * (share + 1) / num_shares;
    EnterPatches(patches, from, to);
  };
  ParallelFor(execution, num_shares, enter_share);
}

void CellIndex::EnterPatches(const std::vector<SurfacePatch>& patches, int from_view, int to_view) {
  const auto for_each = [&](const auto& visit) {
    for (std::size_t i = 0; i < patches.size(); ++i) {
      for (std::size_t k = 0; k < patches[i].sightings.size(); ++k) {
        const int view = patches[i].sightings[k].view;
        if (view >= from_view && view < to_view) visit(i, k, view, views_[view]);
      }
    }
  };
  // Counted first, so that every cell's entries go where they stay.
  for_each([&](std::size_t i, std::size_t k, int /*view*/, Cells& cells) {
    ++cells.first[cells.layout.CellAt(patches[i].pixels[k].x_px) + 1];
  });
  std::vector<std::vector<int>> next(views_.size());
  for (int view = from_view; view < to_view; ++view) {
    Cells& cells = views_[view];
    std::partial_sum(cells.first.begin(), cells.first.end(), cells.first.begin());
    cells.entries.resize(static_cast<std::size_t>(cells.first.back()));
    next[view] = cells.first;
  }
  for_each([&](std::size_t i, std::size_t k, int view, Cells& cells) {
    const Pixel& pixel = patches[i].pixels[k];
    const auto place = static_cast<std::size_t>(next[view][cells.layout.CellAt(pixel.x_px)]++);
    cells.entries[place] = {static_cast<int>(i), static_cast<float>(pixel.depth),
                            pixel.x_px.cast<float>() - patches[i].sightings[k].offset_px,
                            patches[i].normal_in_world.cast<float>()};
  });
}

}  // namespace rigcal::stereo
