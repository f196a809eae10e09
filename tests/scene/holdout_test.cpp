#include "core/scene/holdout.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/scene/expected_error.h"

namespace rigcal {
namespace {

TrackSet RandomTracks(int num_tracks, int num_views) {
  Random random(11);
  TrackSet set;
  for (int i = 0; i < num_tracks; ++i) {
    Track track;
    const int first = static_cast<int>(random.Index(num_views)), length = 2 + static_cast<int>(random.Index(5));
    // View 0 is rare: it must give its share all the same.
    for (int k = 0; k < length; ++k) {
      const int view = (first + k) % num_views;
      if (view != 0 || i % 10 == 0) track.observations.push_back({.view = view, .x_px = {0, 0}});
    }
    if (track.observations.size() >= 2) set.tracks.push_back(track);
  }
  return set;
}

TEST(HoldOut, EveryViewGivesItsShare) {
  TrackSet set = RandomTracks(2000, 12);
  HoldOut(set, 0.15, 1);
  std::vector<double> held(12, 0), all(12, 0);
  for (const Track& track : set.tracks) {
    for (const Observation& o : track.observations) {
      all[o.view] += 1;
      held[o.view] += track.held_out ? 1 : 0;
    }
  }
  for (int v = 0; v < 12; ++v) EXPECT_NEAR(held[v] / all[v], 0.15, 0.03) << "view " << v;
}

TEST(HoldOut, FollowsFromTheSeedAlone) {
  TrackSet a = RandomTracks(500, 6), b = a, c = a;
  HoldOut(a, 0.2, 1);
  HoldOut(b, 0.5, 9);
  HoldOut(b, 0.2, 1);
  HoldOut(c, 0.2, 2);
  int different = 0;
  for (std::size_t i = 0; i < a.tracks.size(); ++i) {
    EXPECT_EQ(a.tracks[i].held_out, b.tracks[i].held_out);
    different += a.tracks[i].held_out != c.tracks[i].held_out ? 1 : 0;
  }
  EXPECT_GT(different, 50);
  HoldOut(a, 0.0, 1);
  for (const Track& track : a.tracks) EXPECT_FALSE(track.held_out);
}

// Paper, Table 1.
TEST(PyramidLevel, IsThatOfThePapersTable) {
  EXPECT_EQ(PyramidLevel(12), 3);
  EXPECT_EQ(PyramidLevel(8), 3);
  EXPECT_EQ(PyramidLevel(7), 2);
  EXPECT_EQ(PyramidLevel(5), 2);
  EXPECT_EQ(PyramidLevel(1.5), 0);
  EXPECT_EQ(PyramidLevel(0.1), 0);
}

}  // namespace
}  // namespace rigcal
