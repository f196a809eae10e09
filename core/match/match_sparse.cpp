#include "core/match/match_sparse.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/ensure.h"
#include "core/geometry/triangulate.h"
#include "core/image/undistort.h"
#include "core/match/link_tracks.h"
#include "core/match/patch_frame.h"

namespace rigcal {
namespace {

/// SIFT stands changes of viewing direction of up to about this.
constexpr double kMaxPairAngleRad = 50 * std::numbers::pi / 180;
constexpr int kNeighbours = 8;
/// A point may be this many times its view's expected error off: Er is a mean, and single points move 2.5 times as far
/// (DESIGN.md section 5, issue 2: "with a mean error of 6 px single points are 14-19 px off").
constexpr double kGatePerExpectedError = 2.5;

struct TriangulatedChain {
  FeatureChain chain;
  Eigen::Vector3d x_in_world;
};

class ChainTriangulation {
 public:
  ChainTriangulation(const std::vector<SiftFeatures>& features, const std::vector<ViewGeometry>& views,
                     const std::vector<double>& expected_error_px)
      : features_(features), views_(views), expected_error_px_(expected_error_px) {}

  /// Leaves the feature out that fits worst until all fit; nothing when fewer than two are left.
  [[nodiscard]] std::optional<TriangulatedChain> operator()(FeatureChain chain) const {
    while (chain.size() >= 2) {
      const auto x_in_world = Triangulate(chain);
      if (!x_in_world) return std::nullopt;
      std::size_t worst = 0;
      double worst_error = 0;  // in units of what is allowed
      for (std::size_t i = 0; i < chain.size(); ++i) {
        const double error = RelativeError(chain[i], *x_in_world);
        if (error > worst_error) worst = i, worst_error = error;
      }
      if (worst_error <= 1) return TriangulatedChain{std::move(chain), *x_in_world};
      chain.erase(chain.begin() + static_cast<std::ptrdiff_t>(worst));
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::optional<Eigen::Vector3d> Triangulate(const FeatureChain& chain) const {
    std::vector<Eigen::Matrix<double, 3, 4>> px_from_world;
    std::vector<Eigen::Vector2d> x_px;
    for (const SparseFeature& f : chain) {
      px_from_world.push_back(views_[f.view].px_from_world);
      x_px.push_back(features_[f.view].x_px[f.feature]);
    }
    return TriangulateInWorld(px_from_world, x_px);
  }

  [[nodiscard]] double RelativeError(const SparseFeature& f, const Eigen::Vector3d& x_in_world) const {
    const auto x_px = ProjectIntoView(views_[f.view], x_in_world);
    const double allowed_px = kGatePerExpectedError * expected_error_px_[f.view];
    return x_px ? (*x_px - features_[f.view].x_px[f.feature]).norm() / allowed_px : HUGE_VAL;
  }

  const std::vector<SiftFeatures>& features_;
  const std::vector<ViewGeometry>& views_;
  const std::vector<double>& expected_error_px_;
};

Observation MakeObservation(const ViewImages& view, int view_index, const SiftFeatures& features, int feature) {
  /// Standard deviation of a SIFT position per coordinate, in units of the feature's scale sigma; and its least value.
  constexpr double kSigmaPerScale = 0.15;
  constexpr double kMinSigmaPx = 0.2;
  const double sigma_px = std::max(kMinSigmaPx, kSigmaPerScale * features.scale_px[feature]);
  return {view_index, OriginalFromUndistorted(view.undistorted_with, features.x_px[feature]),
          sigma_px * sigma_px * Eigen::Matrix2d::Identity(), 1.0f};
}

}  // namespace

Result<TrackSet> MatchSparse(const ImageSet& images, const RigCalibration& calibration,
                             const SparseMatchOptions& options, const Execution& execution) {
  Ensure(images.NumViews() == calibration.NumViews(), "matching needs one picture per view");
  Ensure(options.expected_error_px.size() == images.views.size(), "matching needs an expected error per view");
  const auto features = FindSiftFeatures(images, options.max_features_per_view, execution);
  if (!features) return Cancelled("sparse matching");

  std::vector<PairMatches> pairs;
  for (const auto& [a, b] : NeighbourPairs(calibration, kNeighbours, kMaxPairAngleRad)) pairs.push_back({a, b, {}});
  const bool finished = ParallelFor(execution, static_cast<int>(pairs.size()), [&](int i) {
    PairMatches& pair = pairs[i];
    const EpipolarGate gate{FundamentalMatrix(calibration, pair.view_a, pair.view_b),
                            kGatePerExpectedError * std::hypot(options.expected_error_px[pair.view_a],
                                                               options.expected_error_px[pair.view_b])};
    const SiftFeatures &a = (*features)[pair.view_a], &b = (*features)[pair.view_b];
    pair.matches = MatchFeatures(a, b, gate);
    KeepConsistent(a, b, pair.matches);
  });
  if (!finished) return Cancelled("sparse matching");

  const std::vector<ViewGeometry> views = ViewGeometries(calibration);
  const ChainTriangulation triangulate(*features, views, options.expected_error_px);
  TrackSet set;
  for (const FeatureChain& chain : LinkTracks(*features, pairs)) {
    const auto triangulated = triangulate(chain);
    if (!triangulated) continue;
    Track track;
    track.x_in_world = triangulated->x_in_world;
    track.source = TrackSource::kSparse;
    for (const SparseFeature& f : triangulated->chain) {
      track.observations.push_back(MakeObservation(images.views[f.view], f.view, (*features)[f.view], f.feature));
    }
    set.tracks.push_back(std::move(track));
  }
  return set;
}

}  // namespace rigcal
