#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/scene/recording.h"

namespace rigcal {

/// How long a line may be, its end not counted: seven numbers with all their digits need less than 200.
inline constexpr int kLongestLine_bytes = 512;

/// How far the length of a quaternion may be from 1: four digits after the point are exact enough.
inline constexpr double kUnitTolerance = 1e-3;

/// `K x y z qw qx qy qz`: base_from_flange, metres, Hamilton. The stop has the id K, and as commanded and reported pose
/// the one that is said, its quaternion made exactly unit. Errors: kBadInput: what is wrong with the line, and its
/// limit.
Result<RecordedStop> ParsePose(std::string_view line);

/// The K of a line that need not be right otherwise; "-" where it has none that files can hold.
std::string StopNamed(std::string_view line);

/// The text on one line, without characters that would end it.
std::string OnOneLine(std::string text);

}  // namespace rigcal
