#include "config/utc_text.h"

#include <fmt/chrono.h>

#include <cstdio>

namespace rigcal {

std::string UtcText(std::chrono::system_clock::time_point time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

std::optional<std::chrono::system_clock::time_point> TimeFromUtc(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0;
  double second = 0;
  if (std::sscanf(text.c_str(), "%d-%d-%dT%d:%d:%lfZ", &year, &month, &day, &hour, &minute, &second) != 6) return {};
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return {};
  const auto since = std::chrono::hours(hour) + std::chrono::minutes(minute) + std::chrono::duration<double>(second);
  return std::chrono::sys_days(date) + std::chrono::duration_cast<std::chrono::system_clock::duration>(since);
}

}  // namespace rigcal
