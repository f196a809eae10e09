#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rigcal {

/// The words with a separator between them. (fmt::join of strings trips -Wstringop-overflow of g++ 12 at -O3.)
std::string Joined(const std::vector<std::string>& words, std::string_view separator);

}  // namespace rigcal
