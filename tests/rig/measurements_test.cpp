#include "core/rig/measurements.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/adjust/synthetic_rig.h"

namespace rigcal {
namespace {

using namespace synthetic;

TEST(MeasurementsOf, LeavesOutWhatCannotBeUsed) {
  Random random(1);
  const RigCalibration rig = Ring(6);
  TrackSet tracks = Observe(rig, Surface(50, random), {.sigma_px = 0}, random);
  ASSERT_GT(tracks.tracks.size(), 20u);
  const std::size_t all = MeasurementsOf(rig, tracks, {}).x_in_world.size();
  tracks.tracks[0].held_out = true;
  tracks.tracks[1].observations.resize(1);
  tracks.tracks[2].x_in_world = {0, 0, 1000};  // behind the cameras, which look down from 0.3 rad
  tracks.tracks[3].observations.resize(2);
  tracks.tracks[3].observations[0].x_px.x() = std::numeric_limits<double>::quiet_NaN();
  const MeasurementSet set = MeasurementsOf(rig, tracks, {});
  EXPECT_EQ(set.x_in_world.size(), all - 4);
  EXPECT_EQ(set.track[0], 4);
}

TEST(MeasurementsOf, WhitensEachFeatureByItsSource) {
  Random random(1);
  const RigCalibration rig = Ring(6);
  TrackSet tracks = Observe(rig, Surface(50, random), {.sigma_px = 0}, random);
  tracks.tracks[1].source = TrackSource::kSparse;
  const MeasurementSet set = MeasurementsOf(rig, tracks, {.observation_sigma_px = 0.3, .sparse_sigma_px = 0.6});
  for (const Measurement& m : set.items) {
    EXPECT_NEAR(m.whitening(0, 0), 1 / (set.track[m.point] == 1 ? 0.6 : 0.3), 1e-12);
  }
}

TEST(MeasurementsOf, ScalesCovariancesToTheMedianFeature) {
  Random random(1);
  const RigCalibration rig = Ring(6);
  TrackSet tracks = Observe(rig, Surface(50, random), {.sigma_px = 0}, random);
  for (Track& track : tracks.tracks) {
    for (Observation& o : track.observations) o.covariance_px2 = 49 * Eigen::Matrix2d::Identity();
  }
  tracks.tracks[0].observations[0].covariance_px2 << 4 * 49, 0, 0, 49;
  const MeasurementSet set = MeasurementsOf(rig, tracks, {.observation_sigma_px = 0.3, .weight_by_covariance = true});
  const Eigen::Matrix2d special = (set.items[0].whitening.transpose() * set.items[0].whitening).inverse();
  EXPECT_NEAR(special(0, 0), 4 * 0.09, 1e-9);
  EXPECT_NEAR(special(1, 1), 0.09, 1e-9);
  EXPECT_NEAR(set.items[1].whitening(0, 0), 1 / 0.3, 1e-9);
}

// What a view's features of one source know together: the sum of weight / sigma^2 per coordinate.
TEST(MeasurementsOf, ASharedErrorLimitsWhatASourceOfAViewKnows) {
  Random random(1);
  const RigCalibration rig = Ring(6);
  TrackSet tracks = Observe(rig, Surface(2000, random), {.sigma_px = 0}, random);
  for (std::size_t t = 0; t < tracks.tracks.size(); t += 4) tracks.tracks[t].source = TrackSource::kSparse;
  const MeasurementNoise noise{.observation_sigma_px = 0.3, .sparse_sigma_px = 0.6, .systematic_sigma_px = 0.02};
  const MeasurementSet set = MeasurementsOf(rig, tracks, noise);
  std::array<double, 2> information{}, independent{};
  for (const Measurement& m : set.items) {
    if (m.view != 2) continue;
    const std::size_t source = set.track[m.point] % 4 == 0 ? 1 : 0;
    const double squared = m.whitening(0, 0) * m.whitening(0, 0);
    information[source] += m.weight * squared, independent[source] += squared;
  }
  for (const std::size_t source : {0u, 1u}) {
    EXPECT_GT(independent[source], 0.1 / (0.02 * 0.02));  // else the limit says nothing
    EXPECT_NEAR(1 / information[source], 1 / independent[source] + 0.02 * 0.02, 1e-9);
  }
  for (const Measurement& m : MeasurementsOf(rig, tracks, {}).items) EXPECT_EQ(m.weight, 1);
}

TEST(TriangulateTrack, UndoesDistortion) {
  Random random(1);
  RigCalibration rig = Ring(6);
  rig.cameras[0].k1 = -0.2;
  const TrackSet tracks = Observe(rig, Surface(20, random), {.sigma_px = 0}, random);
  for (const Track& track : tracks.tracks) {
    EXPECT_LT((*TriangulateTrack(rig, track) - track.x_in_world).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace rigcal
