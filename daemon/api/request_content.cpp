#include "daemon/api/request_content.h"

#include <algorithm>
#include <charconv>

namespace rigcal {

using Json = nlohmann::json;

Result<int> NumberFrom(const std::string& text, const char* what) {
  int number = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, number);
  if (parsed.ec == std::errc() && parsed.ptr == end && number >= 1) return number;
  constexpr std::size_t kShown = 32;
  return Fail(ErrorCode::kBadInput, "'{}' is no {}, a number from 1 is needed", text.substr(0, kShown), what);
}

Result<Json> ObjectFrom(const std::string& body, const std::vector<std::string_view>& keys) {
  if (body.empty()) return Json::object();
  Json object;
  try {
    object = Json::parse(body);
  } catch (const Json::exception& error) {
    return Fail(ErrorCode::kBadInput, "the body is no JSON: {}", error.what());
  }
  if (!object.is_object()) return Fail(ErrorCode::kBadInput, "the body must be an object");
  for (const auto& [key, value] : object.items()) {
    if (std::ranges::find(keys, key) == keys.end()) {
      return Fail(ErrorCode::kBadInput, "the body has an unknown key '{}'", key);
    }
  }
  return object;
}

Result<std::string> TextUnder(const Json& object, const char* key, const std::string& fallback, std::size_t longest) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if (found->is_string() && found->get_ref<const std::string&>().size() <= longest) return found->get<std::string>();
  return Fail(ErrorCode::kBadInput, "'{}' must be a text of at most {} characters", key, longest);
}

}  // namespace rigcal
