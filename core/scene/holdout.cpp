#include "core/scene/holdout.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/base/ensure.h"
#include "core/base/random.h"

namespace rigcal {

void HoldOut(TrackSet& tracks, double share, std::uint64_t random_seed) {
  Ensure(share >= 0 && share < 1, "the held-out share lies in [0, 1)");
  int num_views = 0;
  for (Track& track : tracks.tracks) {
    track.held_out = false;
    for (const Observation& o : track.observations) num_views = std::max(num_views, o.view + 1);
  }
  // owed[v]: how many features of view v should be held out and are not yet. A track is taken when its views are, taken
  // together, owed at least half of what it would pay.
  std::vector<double> owed(num_views, 0.0);
  std::vector<std::size_t> order(tracks.tracks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random random(random_seed);
  random.Shuffle(order);
  for (const std::size_t i : order) {
    Track& track = tracks.tracks[i];
    double total_owed = 0;
    for (const Observation& o : track.observations) total_owed += owed[o.view] += share;
    track.held_out = total_owed >= 0.5 * static_cast<double>(track.observations.size()) && share > 0;
    if (track.held_out) {
      for (const Observation& o : track.observations) owed[o.view] -= 1.0;
    }
  }
}

}  // namespace rigcal
