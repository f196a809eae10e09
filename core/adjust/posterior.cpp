#include "core/adjust/posterior.h"

#include <cmath>

#include "core/rig/camera_information.h"
#include "core/rig/projection_uncertainty.h"

namespace rigcal {
namespace {

constexpr int kNumWeakestDirections = 5;  ///< as many as a reader of the report can take in
constexpr int kPointsPerView = 100;       ///< for uncertainty in pixels: the mean over the object is known to 10 %

}  // namespace

Posterior PosteriorAt(const RigCalibration& solution, const MeasurementSet& measurements, const NoiseEstimate& noise,
                      const BundleTerms& terms, const TrackSet& tracks) {
  MeasurementSet weighted = measurements;
  for (std::size_t i = 0; i < weighted.items.size(); ++i) {
    const double weight = noise.weight[i] * measurements.items[i].weight;
    weighted.items[i].whitening *= std::sqrt(weight) / noise.weighted_sigma;
  }
  const Eigen::MatrixXd features = FeatureInformation(solution, terms.free, weighted);
  const Eigen::MatrixXd all = features + SeedInformation(solution, terms.free, terms.anchors, terms.anchor_sigma_px) +
                              IntrinsicsInformation(solution, terms.free, terms.camera_priors);
  const int size = CalibrationCovariance::PoseRow(solution.NumCameras(), solution.NumViews());
  const std::vector<int> rows = terms.free.JointRows();
  Posterior posterior;
  posterior.covariance.joint = Eigen::MatrixXd::Zero(size, size);
  posterior.covariance.joint(rows, rows) = CovarianceFromInformation(all);
  posterior.weakest_directions_px = WeakestDirectionsPx(
      solution, terms.free, features, ObjectViewPoints(solution, tracks, kPointsPerView), kNumWeakestDirections);
  return posterior;
}

}  // namespace rigcal
