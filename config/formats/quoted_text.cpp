#include "config/formats/quoted_text.h"

#include <nlohmann/json.hpp>

namespace rigcal {

std::string Quoted(const std::string& word) {
  return nlohmann::ordered_json(word).dump();
}

std::string XmlQuoted(std::string_view word) {
  std::string quoted;
  for (char character : word) {
    switch (character) {
      case '&':
        quoted += "&amp;";
        break;
      case '<':
        quoted += "&lt;";
        break;
      case '>':
        quoted += "&gt;";
        break;
      case '"':
        quoted += "&quot;";
        break;
      default:
        quoted += character;
    }
  }
  return quoted;
}

}  // namespace rigcal
