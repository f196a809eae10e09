#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace rigcal::sim {

/// In the order of linuxcncrsh's positions.
inline constexpr std::string_view kMdiLetters = "XYZABC";
/// Millimetres and degrees, machine coordinates.
using MdiPosition = std::array<double, kMdiLetters.size()>;

/// What lasts from one line to the next.
struct MdiModes {
  bool inches = false, relative = false, rapid = true;
  double feed_per_min = 0;
};

/// A straight move: where to, and how long it takes at constant speed.
struct MdiMotion {
  MdiPosition target{};
  double duration_s = 0;
};

/// One line of G-code: G0 G1 G4 G20 G21 G53 G90 G91 G94, F, P and the axes X, Z and C. Nothing where it moves nothing.
/// Errors: kBadInput with LinuxCNC's own message.
Result<std::optional<MdiMotion>> ReadMdiLine(std::string_view text, const MdiPosition& from, MdiModes& modes);

}  // namespace rigcal::sim
