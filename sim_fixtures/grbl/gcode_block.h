#pragma once

#include <optional>
#include <string_view>
#include <variant>

#include "sim_fixtures/grbl/axis_motion.h"

namespace rigcal::sim {

/// What a line of G-code says, as far as the simulated controller knows it.
struct GcodeBlock {
  std::optional<int> motion;  ///< G0 or G1
  std::optional<bool> inches, relative;
  bool in_machine = false;      ///< G53
  bool sets_offset = false;     ///< G92
  std::optional<int> offset_l;  ///< the L of G10: 2 or 20
  std::array<std::optional<double>, kNumGrblAxes> axes;
  std::optional<double> feed_per_min;

  [[nodiscard]] bool HasAxes() const { return axes[0] || axes[1] || axes[2]; }
};

/// A line of G-code without spaces, or the number of GRBL's error.
std::variant<GcodeBlock, int> ParseGcode(std::string_view line);

}  // namespace rigcal::sim
