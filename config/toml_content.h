#pragma once

#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// The document's table. Errors: kBadInput with file and line.
Result<toml::table> ParseToml(std::string_view text, const std::string& file);

/// "FILE line N: KEY", how every message about a key begins.
std::string KeyPlace(const std::string& file, const toml::node& node, std::string_view key);

/// Errors: kBadInput, naming the first key that is not known, `what` the table is ("a board file"), and those that are.
Result<void> CheckKeys(const toml::table& table, const std::string& file, std::string_view what,
                       const std::vector<std::string>& known);

struct NumberRange {
  double least = 0, most = 0;
  bool whole = false;
  const char* unit = "";  ///< "metres", for messages; empty for a number without one
};

/// Errors: kBadInput, beginning with `where`: another type, out of range, not finite.
Result<double> TomlNumber(const toml::node& node, const std::string& where, const NumberRange& range);

}  // namespace rigcal
