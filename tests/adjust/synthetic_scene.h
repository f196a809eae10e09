#pragma once

#include "core/adjust/adjust.h"
#include "tests/adjust/synthetic_rig.h"

namespace rigcal::synthetic {

inline constexpr double kAspectSigma = 0.001;  // a rig file

/// A problem for Adjust() with its truth.
struct Scene {
  RigCalibration truth;
  RigCalibration seed;
  std::vector<SurfacePoint> surface;
  TrackSet tracks;
  double expected_error_px = 6;
  AdjustOptions options;

  [[nodiscard]] std::vector<double> ExpectedErrors() const {
    return std::vector<double>(seed.views.size(), expected_error_px);
  }
  [[nodiscard]] Result<Adjustment> Run() const { return Adjust(seed, tracks, ExpectedErrors(), options, {}); }
};

/// A seed drawn from the prior about the truth, so that its pictures are off by about expected_error_px.
inline Scene MakeScene(const RigCalibration& truth, double expected_error_px, const ObservationNoise& noise,
                       std::uint64_t random_seed = 1, int num_points = 800) {
  Random random(random_seed);
  Scene scene;
  scene.truth = truth;
  scene.expected_error_px = expected_error_px;
  scene.surface = Surface(num_points, random);
  scene.tracks = Observe(truth, scene.surface, noise, random);
  const Prior prior = PriorAbout(truth, scene.tracks, expected_error_px, kAspectSigma);
  scene.seed = DrawFromPrior(prior, random);
  scene.options.seed_prior = SeedPrior{scene.seed, expected_error_px};
  scene.options.camera_priors = prior.camera_priors;
  return scene;
}

/// The same with a camera of its own for every view, each with its prior.
inline Scene WithCameraPerView(Scene scene) {
  scene.truth = CameraPerView(scene.truth);
  scene.seed = CameraPerView(scene.seed);
  scene.options.seed_prior->seed = scene.seed;
  scene.options.camera_priors.assign(scene.seed.cameras.size(), scene.options.camera_priors[0]);
  return scene;
}

/// The other way round, for the honesty of the covariance: the truth is drawn from the prior about a seed that is the
/// ideal rig. The anchors are those that Adjust() will choose: they depend on points and visibility, not on noise.
inline Scene MakeSceneWithDrawnTruth(const RigCalibration& seed, double expected_error_px,
                                     const ObservationNoise& noise, std::uint64_t random_seed, int num_points) {
  Random random(random_seed);
  Scene scene;
  scene.seed = seed;
  scene.expected_error_px = expected_error_px;
  scene.surface = Surface(num_points, random);
  const Prior prior =
      PriorAbout(seed, Observe(seed, scene.surface, {.sigma_px = 0}, random), expected_error_px, kAspectSigma);
  scene.truth = DrawFromPrior(prior, random);
  scene.tracks = Observe(scene.truth, scene.surface, noise, random);
  scene.options.seed_prior = SeedPrior{seed, expected_error_px};
  scene.options.camera_priors = prior.camera_priors;
  return scene;
}

}  // namespace rigcal::synthetic
