#include "config/json_text.h"

#include <algorithm>
#include <cmath>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

bool IsPlain(const Json& value) {
  return !value.is_structured() || value.empty();
}

void Append(const Json& value, const std::string& indent, std::string& text) {
  if (IsPlain(value)) {
    Ensure(!value.is_number_float() || std::isfinite(value.get<double>()), "a JSON file holds finite numbers only");
    text += value.dump();
    return;
  }
  if (value.is_array() && std::all_of(value.begin(), value.end(), IsPlain)) {
    const char* separator = "[";
    for (const Json& element : value) {
      text += separator;
      Append(element, indent, text);
      separator = ", ";
    }
    text += ']';
    return;
  }
  const std::string inner = indent + "  ";
  const char* separator = value.is_array() ? "[\n" : "{\n";
  for (const auto& [key, element] : value.items()) {
    text += separator + inner;
    if (value.is_object()) text += Json(key).dump() + ": ";
    Append(element, inner, text);
    separator = ",\n";
  }
  text += '\n' + indent + (value.is_array() ? ']' : '}');
}

}  // namespace

std::string JsonText(const Json& document) {
  std::string text;
  Append(document, "", text);
  return text + '\n';
}

bool IsUtf8(const std::string& text) {
  try {
    Json(text).dump();
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

Json NumberJson(double number) {
  return std::isfinite(number) ? Json(number) : Json(nullptr);
}

Json IntrinsicsJson(const IntrinsicVector& intrinsics) {
  Json json;
  for (int i = 0; i < kNumIntrinsics; ++i) json[kIntrinsicKeys[i]] = intrinsics[i];
  return json;
}

}  // namespace rigcal
