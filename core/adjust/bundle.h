#pragma once

#include <optional>
#include <vector>

#include "core/adjust/adjust.h"
#include "core/rig/free_parameters.h"
#include "core/rig/measurements.h"
#include "core/rig/seed_anchors.h"

namespace rigcal {

/// Everything that a solution depends on but the unknowns themselves.
struct BundleTerms {
  FreeParameters free;  ///< with a rig all poses are
  std::vector<SeedAnchor> anchors;
  double anchor_sigma_px = 1;
  std::vector<CameraPrior> camera_priors;  ///< one per camera, or none
  std::optional<RigTerms> rig;
};

/// Start and solution.
struct BundleUnknowns {
  RigCalibration calibration;
  MeasurementSet measurements;
  std::optional<RigState> rig;  ///< when the terms have one; the calibration's poses follow from it
};

struct BundleLimits {
  double cauchy_scale = 0;  ///< in sigmas of a feature; 0: plain least squares
  int max_iterations = 0;
  double function_tolerance = 0;           ///< relative decrease of the cost at which the solution counts as found
  double initial_trust_region_radius = 0;  ///< of Levenberg-Marquardt: the larger, the nearer to Gauss-Newton
};

/// Minimises the whitened residuals of all measurements and priors over the free parameters and the points, in place
/// (Ceres: points eliminated first, one thread). Returns the number of iterations. Errors: kCancelled; kBadInput when
/// the problem has no finite solution.
Result<int> SolveBundle(const BundleTerms& terms, const BundleLimits& limits, const Execution& execution,
                        BundleUnknowns& unknowns);

}  // namespace rigcal
