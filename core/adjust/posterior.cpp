#include "core/adjust/posterior.h"

#include <cmath>

#include "core/adjust/rig_posterior.h"
#include "core/rig/camera_information.h"
#include "core/rig/projection_uncertainty.h"

namespace rigcal {
namespace {

constexpr int kNumWeakestDirections = 5;  ///< as many as a reader of the report can take in
constexpr int kPointsPerView = 100;       ///< for uncertainty in pixels: the mean over the object is known to 10 %

Eigen::MatrixXd InformationOf(const MeasurementSet& measurements, const NoiseEstimate& noise,
                              const FreeParameters& free, const RigCalibration& solution) {
  MeasurementSet weighted = measurements;
  for (std::size_t i = 0; i < weighted.items.size(); ++i) {
    const double weight = noise.weight[i] * measurements.items[i].weight;
    weighted.items[i].whitening *= std::sqrt(weight) / noise.weighted_sigma;
  }
  return FeatureInformation(solution, free, weighted);
}

}  // namespace

void WritePosterior(const MeasurementSet& measurements, const NoiseEstimate& noise, const BundleTerms& terms,
                    Adjustment& out) {
  const RigCalibration& solution = out.calibration;
  const Eigen::MatrixXd features = InformationOf(measurements, noise, terms.free, solution);
  out.report.weakest_directions_px = WeakestDirectionsPx(
      solution, terms.free, features, ObjectViewPoints(solution, out.tracks, kPointsPerView), kNumWeakestDirections);
  if (terms.rig) {
    WriteRigPosterior(features, terms, out);
    return;
  }
  const Eigen::MatrixXd all = features + SeedInformation(solution, terms.free, terms.anchors, terms.anchor_sigma_px) +
                              IntrinsicsInformation(solution, terms.free, terms.camera_priors);
  const int size = CalibrationCovariance::PoseRow(solution.NumCameras(), solution.NumViews());
  const std::vector<int> rows = terms.free.JointRows();
  CalibrationCovariance covariance{Eigen::MatrixXd::Zero(size, size)};
  covariance.joint(rows, rows) = CovarianceFromInformation(all);
  out.calibration.covariance = std::move(covariance);
}

}  // namespace rigcal
