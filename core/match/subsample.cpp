#include "core/match/subsample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr int kNotInPicture = std::numeric_limits<int>::max();

/// For every patch that `view` sees: its place (0, 1, ..) in the random order of its block. Others: kNotInPicture.
std::vector<int> RanksInBlocks(const std::vector<Patch>& patches, const ViewGeometry& geometry, int view, cv::Size size,
                               int blocks_per_side, Random& random) {
  std::vector<std::vector<int>> blocks(static_cast<std::size_t>(blocks_per_side * blocks_per_side));
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (std::find(patches[i].visible_views.begin(), patches[i].visible_views.end(), view) ==
        patches[i].visible_views.end()) {
      continue;
    }
    const auto x_px = ProjectIntoView(geometry, patches[i].centre_in_world);
    if (!x_px) continue;
    // Pixel (0,0) is a centre, so the picture begins at -0.5.
    const double column = std::floor((x_px->x() + 0.5) / size.width * blocks_per_side);
    const double row = std::floor((x_px->y() + 0.5) / size.height * blocks_per_side);
    if (!(column >= 0 && row >= 0 && column < blocks_per_side && row < blocks_per_side)) continue;
    blocks[static_cast<std::size_t>(row * blocks_per_side + column)].push_back(static_cast<int>(i));
  }
  std::vector<int> ranks(patches.size(), kNotInPicture);
  for (auto& block : blocks) {
    random.Shuffle(block);
    for (std::size_t rank = 0; rank < block.size(); ++rank) ranks[block[rank]] = static_cast<int>(rank);
  }
  return ranks;
}

/// The share of the patches to keep; at least 1 for all.
double ShareToKeep(const std::vector<Patch>& patches, const MatchOptions& options) {
  double num_features = 0;
  for (const Patch& patch : patches) num_features += static_cast<double>(patch.visible_views.size());
  return std::min(options.kept_share, options.max_features / std::max(1.0, num_features));
}

}  // namespace

std::vector<int> SubsamplePatches(const std::vector<Patch>& patches, const std::vector<ViewGeometry>& views,
                                  const ImageSet& images, const MatchOptions& options) {
  std::vector<int> kept(patches.size());
  std::iota(kept.begin(), kept.end(), 0);
  const double share = ShareToKeep(patches, options);
  if (share >= 1 || patches.empty()) return kept;
  Ensure(options.blocks_per_side > 0, "without a block of a picture no feature would be kept");

  std::vector<std::vector<int>> ranks;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Random random(DeriveSeed(options.random_seed, v));
    ranks.push_back(RanksInBlocks(patches, views[v], static_cast<int>(v), images.views[v].SizePx(),
                                  options.blocks_per_side, random));
  }
  std::vector<int> best_rank(patches.size(), kNotInPicture);
  for (const auto& of_view : ranks) {
    for (std::size_t i = 0; i < patches.size(); ++i) best_rank[i] = std::min(best_rank[i], of_view[i]);
  }
  std::vector<int> sorted = best_rank;
  const auto wanted = static_cast<std::size_t>(std::ceil(share * static_cast<double>(patches.size())));
  const std::size_t last = std::clamp<std::size_t>(wanted, 1, patches.size()) - 1;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(last), sorted.end());
  std::vector<bool> keep(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) {
    keep[i] = best_rank[i] <= sorted[last] && best_rank[i] != kNotInPicture;
  }

  for (const auto& of_view : ranks) {  // the floor: views with few features get more of theirs, spread over the blocks
    std::vector<int> missing;
    int num_kept = 0;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      if (of_view[i] == kNotInPicture) continue;
      if (keep[i]) {
        ++num_kept;
      } else {
        missing.push_back(static_cast<int>(i));
      }
    }
    std::stable_sort(missing.begin(), missing.end(), [&](int a, int b) { return of_view[a] < of_view[b]; });
    for (const int i : missing) {
      if (num_kept++ >= options.min_features_per_view) break;
      keep[i] = true;
    }
  }
  std::erase_if(kept, [&](int i) { return !keep[i]; });
  return kept;
}

}  // namespace rigcal
