#pragma once

#include <string>
#include <vector>

#include "core/scene/rig_devices.h"
#include "drivers/grbl/grbl_board.h"

namespace rigcal {

/// GRBL has one unit, the "millimetre": of an axis that turns it is a degree (README.md).
double GrblFromAxis(double value, AxisUnit unit);
double AxisFromGrbl(double value, AxisUnit unit);

/// One straight move, cut into jogs. The controller never holds more of it than it needs to keep going: when the line
/// is lost, or this program, the machine stops by itself after `kLead_s` and the time its acceleration takes.
class JogPath {
 public:
  static constexpr double kLead_s = 0.5;     ///< queued beyond where it is: five looks at the status
  static constexpr double kSegment_s = 0.2;  ///< of one jog
  static constexpr int kMostQueued = 10;     ///< jogs under way; GRBL's planner holds 15

  /// `axes` are the indices into X, Y, Z that move, `speed_per_s` the greatest speed of each, above 0; the others stay.
  JogPath(const GrblPosition& from, const GrblPosition& to, const std::vector<int>& axes,
          const std::vector<double>& speed_per_s, const GrblMachine& machine);

  /// The next jog where one is due with the machine at `position`; empty where none is, or all are sent.
  std::string NextJog(const GrblPosition& position);
  [[nodiscard]] bool AllSent() const { return sent_ >= length_; }

 private:
  [[nodiscard]] double Done(const GrblPosition& position) const;

  GrblPosition from_, to_;
  std::vector<int> axes_;
  double length_ = 0, sent_ = 0;  ///< along the path, controller units
  double lead_ = 0, segment_ = 0, feed_per_min_ = 0;
};

}  // namespace rigcal
