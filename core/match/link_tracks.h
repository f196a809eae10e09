#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/match/pair_matches.h"

namespace rigcal {

/// All matches of one pair of views.
struct PairMatches {
  int view_a;
  int view_b;
  std::vector<FeatureMatch> matches;
};

struct SparseFeature {
  int view;
  int feature;  ///< index into the view's SiftFeatures
};

/// One point of the surface as the matches say it is seen: at most one feature per view, ascending by view.
using FeatureChain = std::vector<SparseFeature>;

/// Joins matches that share a place (union-find). Chains that touch two places of one view contradict themselves and
/// are left out.
std::vector<FeatureChain> LinkTracks(const std::vector<SiftFeatures>& features, const std::vector<PairMatches>& pairs);

}  // namespace rigcal
