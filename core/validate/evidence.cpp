#include "core/validate/evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>

#include "core/base/random.h"
#include "core/geometry/triangulate.h"

namespace rigcal {
namespace {

/// A feature as the triangulation wants it: undistorted pixel and 3x4 projection.
struct PinholeFeature {
  int view;
  Eigen::Vector2d x_px;
};

class PinholeViews {
 public:
  explicit PinholeViews(const RigCalibration& calibration) : calibration_(calibration) {
    for (int j = 0; j < calibration.NumViews(); ++j) {
      px_from_world_.push_back(
          ProjectionMatrix(Undistorted(calibration.CameraOf(j)), calibration.views[j].cam_from_world, 0));
      world_from_px_.push_back(px_from_world_.back().leftCols<3>().inverse());
    }
  }

  [[nodiscard]] std::vector<PinholeFeature> FeaturesOf(const Track& track, const std::vector<bool>& excluded) const {
    std::vector<PinholeFeature> features;
    for (const Observation& o : track.observations) {
      if ((!excluded.empty() && excluded[o.view]) || !o.x_px.allFinite()) continue;
      const auto x_px = UndistortedPx(calibration_.CameraOf(o.view), o.x_px);
      if (x_px) features.push_back({o.view, *x_px});
    }
    return features;
  }

  /// By all features but the one at `left_out` (-1: by all).
  [[nodiscard]] std::optional<Eigen::Vector3d> Triangulate(const std::vector<PinholeFeature>& features,
                                                           int left_out) const {
    std::vector<Eigen::Matrix<double, 3, 4>> p;
    std::vector<Eigen::Vector2d> x_px;
    for (int i = 0; i < static_cast<int>(features.size()); ++i) {
      if (i == left_out) continue;
      p.push_back(px_from_world_[features[i].view]);
      x_px.push_back(features[i].x_px);
    }
    if (p.size() < 2) return std::nullopt;
    return TriangulateInWorld(p, x_px);
  }

  /// Distance in (undistorted) pixels; nothing when the point is not in front of the view.
  [[nodiscard]] std::optional<double> Distance(const PinholeFeature& feature, const Eigen::Vector3d& x_in_world) const {
    const Eigen::Vector3d q = px_from_world_[feature.view] * x_in_world.homogeneous();
    if (!(q.z() > 0)) return std::nullopt;
    return (q.head<2>() / q.z() - feature.x_px).norm();
  }

  /// Variance (mean of both coordinates) with which the other features foretell the one at `left_out`, when each of
  /// them has a variance of one.
  [[nodiscard]] double PredictionVariance(const std::vector<PinholeFeature>& features, int left_out,
                                          const Eigen::Vector3d& x_in_world) const {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    for (int i = 0; i < static_cast<int>(features.size()); ++i) {
      if (i == left_out) continue;
      const Eigen::Matrix<double, 2, 3> j = ByPoint(features[i].view, x_in_world);
      information += j.transpose() * j;
    }
    const Eigen::Matrix<double, 2, 3> j = ByPoint(features[left_out].view, x_in_world);
    const Eigen::Matrix<double, 3, 2> by_information = information.ldlt().solve(j.transpose());
    return 0.5 * (j * by_information).trace();
  }

  /// Unit directions from the cameras towards the features.
  [[nodiscard]] std::vector<Eigen::Vector3d> RaysInWorld(const std::vector<PinholeFeature>& features) const {
    std::vector<Eigen::Vector3d> rays;
    for (const PinholeFeature& f : features) {
      rays.push_back((world_from_px_[f.view] * f.x_px.homogeneous()).normalized());
    }
    return rays;
  }

 private:
  [[nodiscard]] Eigen::Matrix<double, 2, 3> ByPoint(int view, const Eigen::Vector3d& x_in_world) const {
    const auto& p = px_from_world_[view];
    const Eigen::Vector3d q = p * x_in_world.homogeneous();
    const Eigen::Vector2d x_px = q.head<2>() / q.z();
    return (p.topLeftCorner<2, 3>() - x_px * p.block<1, 3>(2, 0)) / q.z();
  }

  const RigCalibration& calibration_;
  std::vector<Eigen::Matrix<double, 3, 4>> px_from_world_;
  std::vector<Eigen::Matrix3d> world_from_px_;  ///< directions only
};

/// The widest angle between two rays, the one at `left_out` aside.
double WidestAngleRad(const std::vector<Eigen::Vector3d>& rays, int left_out) {
  double smallest_cosine = 1;
  for (int a = 0; a < static_cast<int>(rays.size()); ++a) {
    for (int b = 0; b < a; ++b) {
      if (a != left_out && b != left_out) smallest_cosine = std::min(smallest_cosine, rays[a].dot(rays[b]));
    }
  }
  return std::acos(std::clamp(smallest_cosine, -1.0, 1.0));
}

}  // namespace

std::optional<Eigen::Vector2d> UndistortedPx(const Camera& camera, const Eigen::Vector2d& x_px) {
  const auto ray = RayInCam(camera, x_px);
  if (!ray) return std::nullopt;
  return (camera.CalibrationMatrix() * *ray).head<2>();
}

std::vector<CrossResidual> CrossResiduals(const RigCalibration& calibration, const std::vector<Track>& tracks,
                                          const std::vector<bool>& excluded) {
  // A feature that no point of the others can be compared with: as bad as it gets, cut by every robust mean.
  constexpr double kHopelessPx = 1e3;
  // Rays this close tell no depth at all: a failure to meet in front of the cameras is not the cameras' fault. The
  // published temple views 1 and 11 have one and the same pose.
  constexpr double kMinAngleRad = 0.02;
  const PinholeViews views(calibration);
  std::vector<CrossResidual> residuals;
  for (const Track& track : tracks) {
    const std::vector<PinholeFeature> features = views.FeaturesOf(track, excluded);
    const int count = static_cast<int>(features.size());
    if (count < 2) continue;
    const std::vector<Eigen::Vector3d> rays = views.RaysInWorld(features);
    for (int i = 0; i < count; ++i) {
      const int left_out = count > 2 ? i : -1;
      if (WidestAngleRad(rays, left_out) < kMinAngleRad) continue;
      const auto x_in_world = views.Triangulate(features, left_out);
      auto distance = x_in_world ? views.Distance(features[i], *x_in_world) : std::nullopt;
      if (distance && left_out >= 0) *distance /= std::sqrt(1 + views.PredictionVariance(features, i, *x_in_world));
      const double residual_px = distance && std::isfinite(*distance) ? std::min(*distance, kHopelessPx) : kHopelessPx;
      residuals.push_back({features[i].view, residual_px});
    }
  }
  return residuals;
}

double RobustMean(std::vector<double> values) {
  constexpr double kWinsorRatio = 4;  // 2-D residuals of pure noise reach 3 medians in 0.2 % of the cases
  if (values.empty()) return 0;
  const double cut = kWinsorRatio * Median(values);
  double sum = 0;
  for (const double v : values) sum += std::min(v, cut);
  return sum / static_cast<double>(values.size());
}

std::vector<Track> TracksToJudgeBy(const TrackSet& tracks, int max_tracks) {
  const bool any_held_out =
      std::any_of(tracks.tracks.begin(), tracks.tracks.end(), [](const Track& t) { return t.held_out; });
  std::vector<const Track*> candidates;
  for (const Track& track : tracks.tracks) {
    if (track.held_out || !any_held_out) candidates.push_back(&track);
  }
  const std::size_t wanted = std::min(candidates.size(), static_cast<std::size_t>(max_tracks));
  std::vector<Track> chosen;
  for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(*candidates[i * candidates.size() / wanted]);
  return chosen;
}

std::vector<Track> SpreadSubset(const TrackSet& tracks, int num_views, int features_per_view) {
  constexpr std::uint64_t kOrderSeed = 1;  // any fixed order that is not the order of the tracks
  std::vector<std::size_t> order(tracks.tracks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(kOrderSeed);
  random.Shuffle(order);
  std::vector<int> count(num_views, 0);
  std::vector<std::size_t> chosen;
  for (const std::size_t t : order) {
    const auto& observations = tracks.tracks[t].observations;
    const bool wanted = std::any_of(observations.begin(), observations.end(),
                                    [&](const Observation& o) { return count[o.view] < features_per_view; });
    if (!wanted) continue;
    for (const Observation& o : observations) ++count[o.view];
    chosen.push_back(t);
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<Track> subset;
  for (const std::size_t t : chosen) subset.push_back(tracks.tracks[t]);
  return subset;
}

std::vector<ComparePoint> ObjectPoints(const RigCalibration& calibration, const std::vector<Track>& tracks) {
  const PinholeViews views(calibration);
  std::vector<ComparePoint> points;
  for (const Track& track : tracks) {
    const auto x_in_world = views.Triangulate(views.FeaturesOf(track, {}), -1);
    if (!x_in_world) continue;
    ComparePoint point{*x_in_world, {}};
    for (const Observation& o : track.observations) point.views.push_back(o.view);
    points.push_back(std::move(point));
  }
  return points;
}

std::vector<int> FeatureCounts(const std::vector<Track>& tracks, int num_views) {
  std::vector<int> count(num_views, 0);
  for (const Track& track : tracks) {
    for (const Observation& o : track.observations) ++count[o.view];
  }
  return count;
}

Eigen::MatrixXi SharedTracks(const std::vector<Track>& tracks, int num_views) {
  Eigen::MatrixXi shared = Eigen::MatrixXi::Zero(num_views, num_views);
  for (const Track& track : tracks) {
    for (const Observation& a : track.observations) {
      for (const Observation& b : track.observations) ++shared(a.view, b.view);
    }
  }
  return shared;
}

std::vector<int> NeighboursOf(const RigCalibration& calibration, int view) {
  const auto axis = [&](int j) -> Eigen::Vector3d {
    return calibration.views[j].cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  };
  std::vector<int> others;
  for (int j = 0; j < calibration.NumViews(); ++j) {
    if (j != view) others.push_back(j);
  }
  const Eigen::Vector3d own = axis(view);
  std::stable_sort(others.begin(), others.end(), [&](int a, int b) { return own.dot(axis(a)) > own.dot(axis(b)); });
  return others;
}

std::vector<int> PhysicalCameras(const RigCalibration& calibration) {
  std::map<std::string, int> numbers;
  std::vector<int> physical;
  for (const Camera& camera : calibration.cameras) {
    const std::string& key = camera.physical_id.empty() ? camera.id : camera.physical_id;
    physical.push_back(numbers.emplace(key, static_cast<int>(numbers.size())).first->second);
  }
  return physical;
}

}  // namespace rigcal
