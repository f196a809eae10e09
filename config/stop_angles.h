#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// Sorts the ids of stops as a person counts: by number when all are whole numbers, otherwise by their characters.
void SortStops(std::vector<std::string>& ids);

/// The table's angle (radians, > 0 counter-clockwise seen from above) at each stop. `angles_deg` is START:STEP, in
/// degrees, for sorted stops without gaps; or a text file of lines "STOP ANGLE_DEG" ('#' starts a comment), which may
/// have more stops than `ids`. Errors: kNotFound, kIo, kBadInput naming line or stop.
Result<std::map<std::string, double>> StopAngles(const std::string& angles_deg, const std::vector<std::string>& ids);

}  // namespace rigcal
