#pragma once

#include <cmath>

#include "core/rig/projection_uncertainty.h"
#include "tests/adjust/synthetic_scene.h"

namespace rigcal::synthetic {

/// (estimate - truth) / sigma over all poses and intrinsics of many runs, and the stated against the true error in
/// pixels.
struct Honesty {
  double mean = 0;
  double deviation = 0;
  double stated_px = 0;  ///< root mean square of ProjectionSigmaPx
  double true_px = 0;    ///< root mean square over the runs of TruthErrorPx
};

/// Redraws the truth from the priors `num_runs` times (DESIGN.md section 4, issue 2): 0.3 px of noise, 5 % outliers.
inline Honesty RedrawTruth(const RigCalibration& seed, double expected_error_px, int num_points, int num_runs) {
  double sum = 0, sum2 = 0, stated2 = 0, true2 = 0;
  int count = 0;
  for (int run = 0; run < num_runs; ++run) {
    const Scene scene = MakeSceneWithDrawnTruth(seed, expected_error_px, {.sigma_px = 0.3, .outlier_share = 0.05},
                                                DeriveSeed(1, static_cast<std::uint64_t>(run)), num_points);
    const Result<Adjustment> result = scene.Run();
    const Eigen::MatrixXd& joint = result.value().calibration.covariance->joint;
    const Eigen::VectorXd error = Difference(result->calibration, scene.truth);
    for (const int row : AllPinholeParameters(seed).JointRows()) {
      const double z = error[row] / std::sqrt(joint(row, row));
      sum += z, sum2 += z * z, ++count;
    }
    constexpr int kPointsPerView = 100;
    for (const double sigma_px : ProjectionSigmaPx(
             result->calibration, ObjectViewPoints(result->calibration, result->tracks, kPointsPerView))) {
      stated2 += sigma_px * sigma_px / seed.NumViews();
    }
    true2 += std::pow(TruthErrorPx(scene.truth, result->calibration, scene.surface), 2);
  }
  Honesty honesty;
  honesty.mean = sum / count;
  honesty.deviation = std::sqrt(sum2 / count - honesty.mean * honesty.mean);
  honesty.stated_px = std::sqrt(stated2 / num_runs);
  honesty.true_px = std::sqrt(true2 / num_runs);
  return honesty;
}

}  // namespace rigcal::synthetic
