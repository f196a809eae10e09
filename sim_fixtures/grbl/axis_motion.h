#pragma once

#include <array>
#include <deque>

namespace rigcal::sim {

inline constexpr int kNumGrblAxes = 3;
/// Controller units, "millimetres".
using AxisValues = std::array<double, kNumGrblAxes>;

/// A planner without acceleration: straight moves one after the other, each at constant speed.
class AxisMotion {
 public:
  static constexpr std::size_t kMostMoves = 15;  ///< GRBL's planner

  [[nodiscard]] const AxisValues& Position() const { return position_; }
  void SetPosition(const AxisValues& position) { position_ = position; }

  [[nodiscard]] bool Full() const { return moves_.size() >= kMostMoves; }
  [[nodiscard]] bool Empty() const { return moves_.empty(); }
  [[nodiscard]] std::size_t NumFree() const { return kMostMoves - moves_.size(); }
  /// Where the last move ends.
  [[nodiscard]] AxisValues End() const { return moves_.empty() ? position_ : moves_.back().target; }

  /// Without effect where it leads nowhere. speed_per_s > 0, along the path.
  void Add(const AxisValues& target, double speed_per_s);
  /// Moves on for `seconds`, or to the end.
  void Advance(double seconds);
  void Clear() { moves_.clear(); }

 private:
  struct Move {
    AxisValues target;
    double speed_per_s;
  };
  AxisValues position_{};
  std::deque<Move> moves_;
};

/// The straight way between two positions.
double WayBetween(const AxisValues& a, const AxisValues& b);

}  // namespace rigcal::sim
