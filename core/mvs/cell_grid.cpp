#include "core/mvs/cell_grid.h"

#include <numeric>

namespace rigcal::stereo {

CellGrid::CellGrid(const StereoScene& scene) : cell_px_(scene.options.cell_px) {
  for (const StereoView& view : scene.views) {
    columns_.push_back((view.texels.cols + cell_px_ - 1) / cell_px_);
    rows_.push_back((view.texels.rows + cell_px_ - 1) / cell_px_);
    cells_.emplace_back(static_cast<std::size_t>(columns_.back()) * static_cast<std::size_t>(rows_.back()),
                        std::uint8_t{0});
  }
}

std::size_t CellGrid::CellAt(int view, const Eigen::Vector2d& x_px) const {
  const int column = static_cast<int>(x_px.x() + 0.5) / cell_px_, row = static_cast<int>(x_px.y() + 0.5) / cell_px_;
  return static_cast<std::size_t>(row * columns_[view] + column);
}

std::optional<CellGrid::CellPixel> CellGrid::Neighbour(int view, const Eigen::Vector2d& x_px, int columns,
                                                       int rows) const {
  const int column = static_cast<int>(x_px.x() + 0.5) / cell_px_ + columns;
  const int row = static_cast<int>(x_px.y() + 0.5) / cell_px_ + rows;
  if (column < 0 || row < 0 || column >= columns_[view] || row >= rows_[view]) return std::nullopt;
  return CellPixel{column * cell_px_ + (cell_px_ - 1) / 2, row * cell_px_ + (cell_px_ - 1) / 2,
                   static_cast<std::size_t>(row * columns_[view] + column)};
}

void CellGrid::SetPending(int view, std::size_t cell) {
  cells_[view][cell] |= kPending;
  pending_.emplace_back(view, cell);
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

CellIndex::CellIndex(const StereoScene& scene, const std::vector<SurfacePatch>& patches)
    : cell_px_(scene.options.cell_px) {
  for (const StereoView& view : scene.views) {
    const int columns = (view.texels.cols + cell_px_ - 1) / cell_px_,
              rows = (view.texels.rows + cell_px_ - 1) / cell_px_;
    views_.push_back({columns, rows, std::vector<int>(static_cast<std::size_t>(columns * rows) + 1), {}});
  }
  const auto cell_of = [&](const Cells& cells, const Pixel& pixel) {
    const int column = static_cast<int>(pixel.x_px.x() + 0.5) / cell_px_;
    const int row = static_cast<int>(pixel.x_px.y() + 0.5) / cell_px_;
    return static_cast<std::size_t>(row * cells.columns + column);
  };
  // Counted first, so that every cell's entries go where they stay.
  for (const SurfacePatch& patch : patches) {
    for (std::size_t k = 0; k < patch.sightings.size(); ++k) {
      Cells& cells = views_[patch.sightings[k].view];
      ++cells.first[cell_of(cells, patch.pixels[k]) + 1];
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
      const auto place = static_cast<std::size_t>(next[sighting.view][cell_of(cells, pixel)]++);
      cells.entries[place] = {static_cast<int>(i), static_cast<float>(pixel.depth),
                              pixel.x_px.cast<float>() - sighting.offset_px, normal_in_world};
    }
  }
}

}  // namespace rigcal::stereo
