#include "core/match/link_tracks.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace rigcal {
namespace {

class UnionFind {
 public:
  explicit UnionFind(int count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int Root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The smaller number becomes the root, whatever the order of the calls.
  void Join(int i, int j) {
    const int a = Root(i), b = Root(j);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace

std::vector<FeatureChain> LinkTracks(const std::vector<SiftFeatures>& features, const std::vector<PairMatches>& pairs) {
  std::vector<int> first_node(1, 0);  // of each view; a node is a place
  for (const SiftFeatures& of_view : features) first_node.push_back(first_node.back() + of_view.num_places);
  const auto node = [&](int view, int feature) { return first_node[view] + features[view].place[feature]; };

  UnionFind sets(first_node.back());
  for (const PairMatches& pair : pairs) {
    for (const FeatureMatch& match : pair.matches) {
      sets.Join(node(pair.view_a, match.a), node(pair.view_b, match.b));
    }
  }
  std::map<int, FeatureChain> chain_of_root;
  for (int view = 0; view < static_cast<int>(features.size()); ++view) {
    std::vector<bool> taken(static_cast<std::size_t>(features[view].num_places));
    for (int i = 0; i < features[view].Count(); ++i) {
      const int place = features[view].place[i];
      if (taken[place]) continue;
      taken[place] = true;
      chain_of_root[sets.Root(node(view, i))].push_back({view, i});
    }
  }
  std::vector<FeatureChain> chains;
  for (auto& [root, chain] : chain_of_root) {
    const auto same_view = [](const SparseFeature& a, const SparseFeature& b) { return a.view == b.view; };
    const bool contradicts = std::adjacent_find(chain.begin(), chain.end(), same_view) != chain.end();
    if (chain.size() >= 2 && !contradicts) chains.push_back(std::move(chain));
  }
  return chains;
}

}  // namespace rigcal
