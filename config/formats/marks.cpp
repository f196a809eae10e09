#include "config/formats/marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace rigcal {
namespace {

/// The number of images, then as many lines of a name and 21 numbers.
bool IsMiddlebury(std::string_view text) {
  constexpr std::ptrdiff_t kBlanksPerLine = 21;
  int announced = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), announced);
  if (error != std::errc() || end == text.data() + text.size() || *end != '\n') return false;
  const std::string_view lines = text.substr(end + 1 - text.data());
  return std::count(lines.begin(), lines.end(), '\n') == announced &&
         std::count(lines.begin(), lines.end(), ' ') == announced * kBlanksPerLine;
}

}  // namespace

std::string ExportMark(std::string_view format_name) {
  return fmt::format("rigcal export, {}", format_name);
}

bool IsExportOf(ExportFormat format, std::string_view text) {
  if (format == ExportFormat::kMiddlebury) return IsMiddlebury(text);
  return text.find(ExportMark(EntryOf(format).name)) != std::string_view::npos;
}

}  // namespace rigcal
