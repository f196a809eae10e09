#include "sim_fixtures/grbl/axis_motion.h"

#include <cmath>

namespace rigcal::sim {

double WayBetween(const AxisValues& a, const AxisValues& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

void AxisMotion::Add(const AxisValues& target, double speed_per_s) {
  if (WayBetween(End(), target) > 0) moves_.push_back({target, speed_per_s});
}

void AxisMotion::Advance(double seconds) {
  while (!moves_.empty() && seconds > 0) {
    const Move& move = moves_.front();
    const double way = WayBetween(position_, move.target), step = move.speed_per_s * seconds;
    if (step < way) {
      for (int axis = 0; axis < kNumGrblAxes; ++axis) {
        position_[axis] += (move.target[axis] - position_[axis]) * (step / way);
      }
      return;
    }
    seconds -= way / move.speed_per_s;
    position_ = move.target;
    moves_.pop_front();
  }
}

}  // namespace rigcal::sim
