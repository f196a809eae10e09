#include "core/mvs/cell_grid.h"

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

CellIndex::CellIndex(const StereoScene& scene, const std::vector<SurfacePatch>& patches) {
  for (const StereoView& view : scene.views) {
    const CellLayout layout(view, scene.options.cell_px);
    views_.push_back({layout, std::vector<int>(layout.NumCells() + 1), {}});
  }
  // Counted first, so that every cell's entries go where they stay.
  for (const SurfacePatch& patch : patches) {
    for (std::size_t k = 0; k < patch.sightings.size(); ++k) {
      Cells& cells = views_[patch.sightings[k].view];
      ++cells.first[cells.layout.CellAt(patch.pixels[k].x_px) + 1];
    }
  }
  std::vector<std::vector<int>> next;
  for (Cells& cells : views_) {
    std::partial_sum(cells.first.begin(), cells.first.end(), cells.first.begin());
    cells.entries.resize(static_cast<std::size_t>(cells.first.back()));
    next.push_back(cells.first);
  }
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const Eigen::Vector3f normal_in_world = patches[i].normal_in_world.cast<float>();
    for (std::size_t k = 0; k < patches[i].sightings.size(); ++k) {
      const Sighting& sighting = patches[i].sightings[k];
      const Pixel& pixel = patches[i].pixels[k];
      Cells& cells = views_[sighting.view];
      const auto place = static_cast<std::size_t>(next[sighting.view][cells.layout.CellAt(pixel.x_px)]++);
      cells.entries[place] = {static_cast<int>(i), static_cast<float>(pixel.depth),
                              pixel.x_px.cast<float>() - sighting.offset_px, normal_in_world};
    }
  }
}

}  // namespace rigcal::stereo
