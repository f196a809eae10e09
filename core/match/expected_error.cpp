#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/ensure.h"
#include "core/geometry/triangulate.h"
#include "core/match/link_tracks.h"
#include "core/match/match_sparse.h"
#include "core/match/patch_frame.h"

namespace rigcal {
namespace {

constexpr int kMaxFeaturesPerView = 2000;
constexpr int kNeighbours = 4;
constexpr double kMaxPairAngleRad = 50 * std::numbers::pi / 180;
/// Fewer observations say nothing about a set, or about one view.
constexpr int kMinObservations = 60;
constexpr int kMinObservationsPerView = 15;
/// Share of the largest residuals taken for mismatches.
constexpr double kMismatchShare = 0.05;
/// Er never falls below: SIFT alone is off by half a pixel.
constexpr double kMinExpectedErrorPx = 1.0;
/// From the root mean square of what is seen to a conservative mean displacement. Measured on templeSparseRing, 0.5 to
/// 12 px: 1.0 to 1.4 times the truth when all views share one error of the intrinsics, 1.6 to 1.9 times otherwise.
constexpr double kConservative = 1.6;

/// A view this many times worse than all together was moved by itself (a bumped camera), and searches must reach it.
/// When all views are off alike the worst one has 1.4 to 2 times as much (400 x 300, plaster, 6 and 12 px).
constexpr double kBumpedRatio = 2.5;

/// One observation's distance from its track's point, blown up by what the point's three unknowns have swallowed: of
/// 2 n numbers 2 n - 3 are left.
struct Residual {
  int view;
  double px;
};

std::vector<Residual> ResidualsOf(const std::vector<FeatureChain>& chains, const std::vector<SiftFeatures>& features,
                                  const std::vector<ViewGeometry>& views) {
  std::vector<Residual> residuals;
  for (const FeatureChain& chain : chains) {
    std::vector<Eigen::Matrix<double, 3, 4>> px_from_world;
    std::vector<Eigen::Vector2d> x_px;
    for (const SparseFeature& f : chain) {
      px_from_world.push_back(views[f.view].px_from_world);
      x_px.push_back(features[f.view].x_px[f.feature]);
    }
    const auto x_in_world = TriangulateInWorld(px_from_world, x_px);
    if (!x_in_world) continue;
    const auto n = static_cast<double>(chain.size());
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const auto projected = ProjectIntoView(views[chain[i].view], *x_in_world);
      if (projected)
        residuals.push_back({chain[i].view, (*projected - x_px[i]).norm() * std::sqrt(2 * n / (2 * n - 3))});
    }
  }
  return residuals;
}

double TrimmedRms(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto count = static_cast<std::size_t>(std::ceil((1 - kMismatchShare) * static_cast<double>(values.size())));
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += values[i] * values[i];
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
}

ExpectedErrorEstimate Summarise(const std::vector<Residual>& residuals, int num_views) {
  ExpectedErrorEstimate estimate;
  estimate.num_matches = static_cast<int>(residuals.size());
  if (estimate.num_matches < kMinObservations) {
    estimate.assumed = true;
    estimate.overall_px = kAssumedErrorPx;
    estimate.per_view_px.assign(static_cast<std::size_t>(num_views), kAssumedErrorPx);
    return estimate;
  }
  std::vector<double> all;
  std::vector<std::vector<double>> per_view(static_cast<std::size_t>(num_views));
  for (const Residual& r : residuals) {
    all.push_back(r.px);
    per_view[r.view].push_back(r.px);
  }
  const auto conservative = [](double rms_px) { return std::max(kMinExpectedErrorPx, kConservative * rms_px); };
  const double typical_px = conservative(TrimmedRms(all));
  estimate.overall_px = typical_px;
  for (const auto& of_view : per_view) {
    const bool enough = static_cast<int>(of_view.size()) >= kMinObservationsPerView;
    estimate.per_view_px.push_back(enough ? conservative(TrimmedRms(of_view)) : std::max(typical_px, kAssumedErrorPx));
    if (enough && estimate.per_view_px.back() > kBumpedRatio * typical_px) {
      estimate.overall_px = std::max(estimate.overall_px, estimate.per_view_px.back());
    }
  }
  return estimate;
}

}  // namespace

Result<ExpectedErrorEstimate> EstimateExpectedError(const ImageSet& images, const RigCalibration& calibration,
                                                    const Execution& execution) {
  Ensure(images.NumViews() == calibration.NumViews(), "matching needs one picture per view");
  const auto features = FindSiftFeatures(images, kMaxFeaturesPerView, execution);
  if (!features) return Cancelled("estimating the expected error");
  std::vector<PairMatches> pairs;
  for (const auto& [a, b] : NeighbourPairs(calibration, kNeighbours, kMaxPairAngleRad)) pairs.push_back({a, b, {}});
  const bool finished = ParallelFor(execution, static_cast<int>(pairs.size()), [&](int i) {
    const SiftFeatures &a = (*features)[pairs[i].view_a], &b = (*features)[pairs[i].view_b];
    pairs[i].matches = MatchFeatures(a, b, std::nullopt);
    KeepConsistent(a, b, pairs[i].matches);
  });
  if (!finished) return Cancelled("estimating the expected error");
  return Summarise(ResidualsOf(LinkTracks(*features, pairs), *features, ViewGeometries(calibration)),
                   images.NumViews());
}

}  // namespace rigcal
