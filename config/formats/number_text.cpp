#include "config/formats/number_text.h"

#include <fmt/format.h>

namespace rigcal {

std::string NumberText(double number) {
  return fmt::format("{:.17g}", number);
}

std::string NumbersText(const std::vector<double>& numbers, std::string_view separator) {
  std::string text;
  for (double number : numbers) {
    if (!text.empty()) text += separator;
    text += NumberText(number);
  }
  return text;
}

}  // namespace rigcal
