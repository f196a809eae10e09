#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/validate/compare.h"

namespace rigcal {

/// Object points as text: a line 'x y z' or 'x y z k v1 .. vk' for each, with the indices (from 0) of the k reference
/// views that see it; '#' starts a comment line. Without views a point is judged in all. Errors: kBadInput, also for an
/// index that is not below num_views.
Result<std::vector<ComparePoint>> ParsePoints(std::string_view text, const std::string& file, int num_views);

}  // namespace rigcal
