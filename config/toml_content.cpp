#include "config/toml_content.h"

#include <algorithm>

#include "core/base/joined.h"

namespace rigcal {

Result<toml::table> ParseToml(std::string_view text, const std::string& file) {
  toml::parse_result parsed = toml::parse(text, file);
  if (parsed) return std::move(parsed).table();
  return Fail(ErrorCode::kBadInput, "{} line {}: not TOML: {}", file, parsed.error().source().begin.line,
              parsed.error().description());
}

std::string KeyPlace(const std::string& file, const toml::node& node, std::string_view key) {
  return fmt::format("{} line {}: {}", file, node.source().begin.line, key);
}

Result<void> CheckKeys(const toml::table& table, const std::string& file, std::string_view what,
                       const std::vector<std::string>& known) {
  for (const auto& [name, node] : table) {
    if (std::ranges::find(known, name.str()) != known.end()) continue;
    return Fail(ErrorCode::kBadInput, "{} is no key of {}; known are {}", KeyPlace(file, node, name.str()), what,
                Joined(known, ", "));
  }
  return {};
}

Result<double> TomlNumber(const toml::node& node, const std::string& where, const NumberRange& range) {
  std::string kind = range.whole ? "a whole number" : "a number";
  if (*range.unit != '\0') kind += fmt::format(" in {}", range.unit);
  if (!node.is_integer() && (range.whole || !node.is_floating_point()))
    return Fail(ErrorCode::kBadInput, "{} must be {} from {:.6g} to {:.6g}", where, kind, range.least, range.most);
  const double value = node.is_integer() ? static_cast<double>(node.ref<std::int64_t>()) : node.ref<double>();
  if (!(value >= range.least && value <= range.most))
    return Fail(ErrorCode::kBadInput, "{} = {} is outside its range, {} from {:.6g} to {:.6g}", where, value, kind,
                range.least, range.most);
  return value;
}

}  // namespace rigcal
