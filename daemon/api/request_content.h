#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// A whole number from 1, as in a path. `what` names it in messages. Errors: kBadInput.
Result<int> NumberFrom(const std::string& text, const char* what);

/// The body of a request, an object with no other keys than these. An empty body is an empty object. Errors: kBadInput.
Result<nlohmann::json> ObjectFrom(const std::string& body, const std::vector<std::string_view>& keys);

/// A text under a key, `fallback` when it is not there. Errors: kBadInput: no text, or a longer one.
Result<std::string> TextUnder(const nlohmann::json& object, const char* key, const std::string& fallback,
                              std::size_t longest);

}  // namespace rigcal
