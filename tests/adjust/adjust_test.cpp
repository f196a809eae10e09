#include "core/adjust/adjust.h"

#include <gtest/gtest.h>

#include "core/base/ensure.h"
#include "tests/adjust/synthetic_rig.h"

namespace rigcal {
namespace {

using namespace synthetic;

struct Scene {
  RigCalibration truth;
  RigCalibration seed;
  std::vector<SurfacePoint> surface;
  TrackSet tracks;
  double expected_error_px = 6;
  AdjustOptions options;

  Result<Adjustment> Run() const {
    return Adjust(seed, tracks, std::vector<double>(seed.views.size(), expected_error_px), options, {});
  }
};

/// A seed drawn from the prior about the truth, so that its pictures are off by about expected_error_px.
Scene MakeScene(const RigCalibration& truth, double expected_error_px, const ObservationNoise& noise,
                std::uint64_t random_seed = 1, int num_points = 1500) {
  Random random(random_seed);
  Scene scene;
  scene.truth = truth;
  scene.expected_error_px = expected_error_px;
  scene.surface = Surface(num_points, random);
  scene.tracks = Observe(truth, scene.surface, noise, random);
  const FreeParameters free = AllPinholeParameters(truth);
  const auto priors = PriorsOf(truth, 0.001);
  const auto anchors = ChooseSeedAnchors({truth, expected_error_px}, scene.tracks);
  const Eigen::MatrixXd information =
      SeedInformation(truth, free, anchors, expected_error_px) + IntrinsicsInformation(truth, free, priors);
  scene.seed = DrawFromPrior(truth, free, information, random);
  scene.options.seed_prior = SeedPrior{scene.seed, expected_error_px};
  scene.options.camera_priors = priors;
  return scene;
}

TEST(Adjust, RecoversARing) {
  const Scene scene = MakeScene(Ring(16), 6, {.sigma_px = 0.3, .outlier_share = 0.05});
  const auto result = scene.Run();
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(TruthErrorPx(scene.truth, scene.seed, scene.surface), 1.5);
  EXPECT_LT(TruthErrorPx(scene.truth, result->calibration, scene.surface), 0.12);
  EXPECT_NEAR(result->report.observation_sigma_px, 0.33, 0.05);
}

TEST(Adjust, RecoversAHemisphere) {
  const Scene scene = MakeScene(Hemisphere(16), 6, {.sigma_px = 0.3, .outlier_share = 0.05});
  const auto result = scene.Run();
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_LT(TruthErrorPx(scene.truth, result->calibration, scene.surface), 0.12);
}

}  // namespace
}  // namespace rigcal
