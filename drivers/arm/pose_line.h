#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/scene/recording.h"

namespace rigcal {

/// How far the length of a quaternion may be from 1: four digits after the point are exact enough.
inline constexpr double kUnitTolerance = 1e-3;

/// `K x y z qw qx qy qz`: base_from_flange, metres, Hamilton. The stop has the id K, and as commanded and reported pose
/// the one that is said, its quaternion made exactly unit. Errors: kBadInput: what is wrong with the line, and its
/// limit.
Result<RecordedStop> ParsePose(std::string_view line);

/// The K of a line that need not be right otherwise; "-" where it has none that files can hold.
std::string StopNamed(std::string_view line);

}  // namespace rigcal
