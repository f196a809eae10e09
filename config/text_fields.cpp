#include "config/text_fields.h"

#include <charconv>
#include <cmath>

namespace rigcal {
namespace {

constexpr std::string_view kBlank = " \t\r";
constexpr std::size_t kQuotedLength = 40;  // longest piece of a broken file that a message repeats, in characters

std::string_view Quoted(std::string_view field) {
  return field.substr(0, kQuotedLength);
}

}  // namespace

std::vector<TextLine> SplitLines(std::string_view text) {
  std::vector<TextLine> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back({static_cast<int>(lines.size()) + 1, line});
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return lines;
}

std::vector<std::string_view> SplitFields(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = line.find_first_of(kBlank, begin);
    fields.push_back(line.substr(begin, end - begin));
    begin = end == std::string_view::npos ? end : line.find_first_not_of(kBlank, end);
  }
  return fields;
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

Result<std::vector<double>> ParseNumbers(std::span<const std::string_view> fields, const std::string& where) {
  std::vector<double> numbers;
  for (std::string_view field : fields) {
    std::string_view digits = field;
    if (digits.starts_with('+')) digits.remove_prefix(1);  // std::from_chars knows no plus sign
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc() || end != digits.data() + digits.size())
      return Fail(ErrorCode::kBadInput, "{}: '{}' is not a number", where, Quoted(field));
    if (!std::isfinite(number))
      return Fail(ErrorCode::kBadInput, "{}: '{}' is not a finite number", where, Quoted(field));
    numbers.push_back(number);
  }
  return numbers;
}

Result<int> ParseCount(std::string_view field, const std::string& where) {
  int count = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), count);
  if (error != std::errc() || end != field.data() + field.size() || count < 0)
    return Fail(ErrorCode::kBadInput, "{}: '{}' is not a whole number", where, Quoted(field));
  return count;
}

}  // namespace rigcal
