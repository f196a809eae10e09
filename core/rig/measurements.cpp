#include "core/rig/measurements.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/triangulate.h"

namespace rigcal {
namespace {

/// How much better or worse than the median one feature may claim to be: its covariance stems from a handful of pixels.
constexpr double kMinSigmaRatio = 0.5, kMaxSigmaRatio = 3;

bool HasOwnCovariance(const Observation& observation) {
  const Eigen::Matrix2d& c = observation.covariance_px2;
  return c.allFinite() && c != Eigen::Matrix2d::Identity() && c(0, 0) > 0 && c.determinant() > 0;
}

/// The sigma (geometric mean over both directions) of the median feature that states one; 1 when none does.
double MedianStatedSigma(const TrackSet& tracks) {
  std::vector<double> sigmas;
  for (const Track& track : tracks.tracks) {
    for (const Observation& observation : track.observations) {
      if (!track.held_out && HasOwnCovariance(observation)) {
        sigmas.push_back(std::pow(observation.covariance_px2.determinant(), 0.25));
      }
    }
  }
  if (sigmas.empty()) return 1;
  const auto middle = sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2);
  std::nth_element(sigmas.begin(), middle, sigmas.end());
  return *middle;
}

Eigen::Matrix2d Whitening(const Observation& observation, double sigma_px, double median_stated_sigma, bool own) {
  if (!own || !HasOwnCovariance(observation)) return Eigen::Matrix2d::Identity() / sigma_px;
  const Eigen::Matrix2d relative = observation.covariance_px2 / (median_stated_sigma * median_stated_sigma);
  const double ratio = std::pow(relative.determinant(), 0.25);
  const double scale = std::clamp(ratio, kMinSigmaRatio, kMaxSigmaRatio) / ratio * sigma_px;
  const Eigen::Matrix2d covariance_px2 = scale * scale * relative;
  return covariance_px2.llt().matrixL().solve(Eigen::Matrix2d::Identity());
}

/// N independent errors of sigma s beside a common one of sigma c: the mean is known to s^2 / N + c^2, as from
/// N / (1 + N c^2 / s^2) independent ones.
void WeighBySystematicError(const TrackSet& tracks, int num_views, const MeasurementNoise& noise, MeasurementSet& set) {
  const auto is_sparse = [&](const Measurement& m) {
    return tracks.tracks[set.track[m.point]].source == TrackSource::kSparse;
  };
  std::vector<std::array<int, 2>> num_features(static_cast<std::size_t>(num_views));
  for (const Measurement& m : set.items) ++num_features[m.view][is_sparse(m) ? 1 : 0];
  for (Measurement& m : set.items) {
    const double sigma_px = is_sparse(m) ? noise.sparse_sigma_px : noise.observation_sigma_px;
    const double ratio = noise.systematic_sigma_px / sigma_px;
    m.weight = 1 / (1 + num_features[m.view][is_sparse(m) ? 1 : 0] * ratio * ratio);
  }
}

}  // namespace

std::optional<Eigen::Vector3d> TriangulateTrack(const RigCalibration& calibration, const Track& track) {
  std::vector<Eigen::Matrix<double, 3, 4>> px_from_world;
  std::vector<Eigen::Vector2d> x_px;
  for (const Observation& observation : track.observations) {
    const Camera& camera = calibration.CameraOf(observation.view);
    const std::optional<Eigen::Vector3d> ray = RayInCam(camera, observation.x_px);
    if (!ray) continue;
    x_px.push_back((camera.CalibrationMatrix() * *ray).head<2>());
    px_from_world.push_back(
        ProjectionMatrix(Undistorted(camera), calibration.views[observation.view].cam_from_world, 0));
  }
  if (x_px.size() < 2) return std::nullopt;
  return TriangulateInWorld(px_from_world, x_px);
}

MeasurementSet MeasurementsOf(const RigCalibration& calibration, const TrackSet& tracks,
                              const MeasurementNoise& noise) {
  const double median_stated_sigma = noise.weight_by_covariance ? MedianStatedSigma(tracks) : 1;
  MeasurementSet set;
  for (int t = 0; t < static_cast<int>(tracks.tracks.size()); ++t) {
    const Track& track = tracks.tracks[t];
    if (track.held_out || !track.x_in_world.allFinite()) continue;
    const double sigma_px = track.source == TrackSource::kSparse ? noise.sparse_sigma_px : noise.observation_sigma_px;
    const std::size_t first = set.items.size();
    for (const Observation& observation : track.observations) {
      const Eigen::Vector3d x_in_cam = calibration.views[observation.view].cam_from_world * track.x_in_world;
      if (!observation.x_px.allFinite() || !(x_in_cam.z() > 0)) continue;
      set.items.push_back({static_cast<int>(set.track.size()), observation.view, observation.x_px,
                           Whitening(observation, sigma_px, median_stated_sigma, noise.weight_by_covariance)});
    }
    if (set.items.size() < first + 2) {
      set.items.resize(first);
      continue;
    }
    set.track.push_back(t);
    set.x_in_world.push_back(track.x_in_world);
  }
  WeighBySystematicError(tracks, calibration.NumViews(), noise, set);
  return set;
}

}  // namespace rigcal
