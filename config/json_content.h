#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "core/geometry/rigid3.h"

namespace rigcal {

/// Content of a JSON file that cannot be used. Thrown while a document is taken apart, as the library does for a
/// missing key or a wrong type; ReadDocument turns both into an Error.
class BadContent : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <typename... Args>
[[noreturn]] void Refuse(fmt::format_string<Args...> format, Args&&... args) {
  throw BadContent(fmt::format(format, std::forward<Args>(args)...));
}

/// What the keys "format" and "version" of one of this project's files say; up to this version it can be read.
struct DocumentFormat {
  const char* name;
  int version;
};

/// Throws BadContent unless the value is a whole number within low .. high; `what` names it.
int WholeNumber(const nlohmann::ordered_json& json, int low, int high, const char* what);

/// The array under a key. Throws BadContent when it is something else, which a loop would take for one.
const nlohmann::ordered_json& List(const nlohmann::ordered_json& json, const char* key);

/// {"rotation": {"w", "x", "y", "z"}, <translation_key>: [x, y, z]} and back; the key carries the unit where it is
/// known.
nlohmann::ordered_json PoseJson(const Rigid3d& b_from_a, const char* translation_key);
Rigid3d PoseFrom(const nlohmann::ordered_json& json, const char* translation_key, const std::string& where);

/// Errors: kBadInput (another format), kUnsupported (a newer version).
Result<void> CheckFormat(const nlohmann::ordered_json& json, const std::string& file, const DocumentFormat& format);

/// The Error for what was thrown while `file` was taken apart.
tl::unexpected<Error> BadDocument(const std::string& file, const std::string& what);

/// Parses a JSON document, checks its format and hands it to `read`, which may throw. `file` starts every message.
template <typename Content, typename Read>
Result<Content> ReadDocument(std::string_view text, const std::string& file, const DocumentFormat& format,
                             const Read& read) {
  try {
    const auto json = nlohmann::ordered_json::parse(text);
    if (const Result<void> known = CheckFormat(json, file, format); !known) return Fail(known.error());
    return read(json);
  } catch (const nlohmann::json::exception& error) {
    return BadDocument(file, error.what());
  } catch (const BadContent& error) {
    return BadDocument(file, error.what());
  }
}

}  // namespace rigcal
