#include "core/match/match.h"

#include <gtest/gtest.h>

#include "tests/match/synthetic_plane.h"

namespace rigcal {
namespace {

TEST(Match, FindsFeaturesToAHundredthOfAPixelWithoutNoise) {
  const test::WaveTexture texture(4.0, 30.0, 0.15, 7);
  const auto scene = test::RenderPlane(
      texture, {test::LookAtOrigin("a", 1000, 0, 0), test::LookAtOrigin("b", 1000, 0.35, 0)}, {200, 160}, 3);
  MatchOptions options;
  options.expected_error_px.assign(2, 2.0);
  const auto tracks = Match(scene.images, scene.truth, test::PatchesOnPlane(2, 4.3, 20), options, {});
  ASSERT_TRUE(tracks.has_value());
  ASSERT_GT(tracks->tracks.size(), 300u);
  double sum_of_squares = 0;
  for (const Track& track : tracks->tracks) {
    const Observation &reference = track.observations[0], &found = track.observations[1];
    sum_of_squares +=
        (found.x_px - test::TransferOverPlane(scene.truth, reference.view, reference.x_px, found.view)).squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum_of_squares / static_cast<double>(tracks->tracks.size())), 0.01);
}

}  // namespace
}  // namespace rigcal
