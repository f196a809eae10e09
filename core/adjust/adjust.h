#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/execution.h"
#include "core/rig/measurements.h"
#include "core/rig/priors.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

/// Where the rig stands.
struct RigState {
  RigModel model;                      ///< with the geometry and mounts of the moment
  std::vector<StopError> stop_errors;  ///< per stop
};

/// The views' poses are those that a rig gives them at its stops.
struct RigTerms {
  RigPrior prior;  ///< takes the place of the seed prior and of the camera priors
  RigState start;  ///< gives the poses with which the adjustment starts
  std::vector<StopPosition> stops;
  std::vector<StopError> stop_error_sigma;  ///< per stop: of the prior about zero; 0: held at zero
  std::vector<int> stop_of_view;
  std::vector<std::string> axes;  ///< their names, for whoever reads the result
};

struct AdjustOptions {
  IntrinsicsMode intrinsics = IntrinsicsMode::kPerCamera;
  bool refine_distortion = false;
  MeasurementNoise noise;                  ///< of the features, before anything is known of the fit
  double cauchy_scale_px = 0.5;            ///< robust loss (point 4); 0: plain least squares (--method paper)
  double min_expected_error_px = 4;        ///< floor of the new Er: one pixel at level L (point 2)
  int min_features_per_view = 100;         ///< a view with fewer keeps its Er (point 2)
  std::vector<CameraPrior> camera_priors;  ///< one per camera; empty: none (--method paper)
  std::optional<SeedPrior> seed_prior;     ///< none for --method paper
  std::vector<bool> fixed_views;           ///< --fix-cameras; empty: none fixed
  bool estimate_covariance = true;         ///< needs a gauge: a seed prior or a fixed view
  std::optional<RigTerms> rig;             ///< nothing: a free pose for each view
  double contradiction_sigmas = 5;         ///< a stop or mount farther than this from the rig contradicts it (issue 3)
  bool paper = false;  ///< five free intrinsics per view, sum of squares (1), Er = mean + 3 sigma for all views alike
};

struct AdjustReport {
  int num_tracks = 0, num_observations = 0;                  ///< used, without the held-out ones and the dropped ones
  int num_dropped_tracks = 0, num_dropped_observations = 0;  ///< grossly wrong, found after a first solution
  int num_iterations = 0;                                    ///< of Ceres, all solutions together
  double reprojection_mean_px = 0, reprojection_std_px = 0;
  std::vector<double> residual_px;        ///< per view: mean over its features, 0 without any
  std::vector<int> num_features;          ///< per view
  std::vector<double> expected_error_px;  ///< per view: the Er of the next round
  double observation_sigma_px = 0;        ///< as found from the residuals; scales the covariance
  /// Image motion at the object, one sigma, of the directions that the features alone determine worst, largest first:
  /// see WeakestDirectionsPx(). Empty without covariance.
  std::vector<double> weakest_directions_px;
};

struct RigOutcome {
  RigState state;
  std::vector<StopError> stop_error_sigma;  ///< zeros without covariance
  /// Stops and cameras that are not where the rig has them, one sentence each; their priors were let go.
  std::vector<std::string> contradictions;
  std::vector<std::string> slips;  ///< those of them that say where the positioner slipped
  bool scale_is_lost = false;      ///< no camera kept its place: lengths are free
};

struct Adjustment {
  /// Refined, in the seed's gauge and scale, with covariance when asked for; with a rig and a covariance also the rig.
  RigCalibration calibration;
  /// With refined x_in_world and without what was dropped as grossly wrong; held-out tracks are whole, triangulated
  /// anew (where that fails they keep their point).
  TrackSet tracks;
  AdjustReport report;
  std::optional<RigOutcome> rig;  ///< when the options have one
};

/// Bundle adjustment (paper equation (1), with the priors of DESIGN.md section 3). `expected_error_px` is each view's
/// Er of this round. With a rig `start` has the poses that follow from its start. Reproducible bit by bit: Ceres runs
/// with one thread. Errors: kCancelled; kBadInput when nothing is left to adjust.
Result<Adjustment> Adjust(const RigCalibration& start, const TrackSet& tracks,
                          const std::vector<double>& expected_error_px, const AdjustOptions& options,
                          const Execution& execution);

}  // namespace rigcal
