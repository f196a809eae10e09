#include "config/stop_angles.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

#include "config/read_file.h"
#include "config/text_fields.h"

namespace rigcal {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr std::size_t kMaxDigits = 9;  ///< of a stop's number: fits an int

std::optional<int> NumberOf(const std::string& id) {
  if (id.empty() || id.size() > kMaxDigits || id.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  return std::stoi(id);
}

bool AllNumbers(const std::vector<std::string>& ids) {
  return std::all_of(ids.begin(), ids.end(), [](const std::string& id) { return NumberOf(id).has_value(); });
}

/// START:STEP would give all stops after a missing one the wrong angle.
Result<void> CheckNoGap(const std::vector<std::string>& ids) {
  const auto word = std::ranges::find_if(ids, [](const std::string& id) { return !NumberOf(id); });
  if (word != ids.end())
    return Fail(ErrorCode::kBadInput,
                "--angles-deg START:STEP needs stops that are numbers of at most {} digits, '{}' is none; give a file "
                "of angles",
                kMaxDigits, *word);
  for (std::size_t i = 2; i < ids.size(); ++i) {
    const int first = *NumberOf(ids[1]) - *NumberOf(ids[0]), step = *NumberOf(ids[i]) - *NumberOf(ids[i - 1]);
    if (step != first)
      return Fail(
          ErrorCode::kBadInput,
          "--angles-deg START:STEP needs stops without gaps: from stop '{}' to '{}' is {}, from '{}' to '{}' is "
          "{}; give a file of angles",
          ids[0], ids[1], first, ids[i - 1], ids[i], step);
  }
  return {};
}

/// START and STEP in degrees; nothing when the text is the name of a file.
std::optional<std::array<double, 2>> StartAndStep(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return std::nullopt;
  const std::string start = text.substr(0, colon), step = text.substr(colon + 1);
  const std::array<std::string_view, 2> fields = {Trimmed(start), Trimmed(step)};
  const Result<std::vector<double>> numbers = ParseNumbers(fields, "--angles-deg");
  if (!numbers) return std::nullopt;
  return std::array{(*numbers)[0], (*numbers)[1]};
}

Result<std::map<std::string, double>> AnglesFromFile(const std::filesystem::path& path) {
  const Result<std::string> text = ReadFile(path);
  if (!text) return Fail(text.error());
  std::map<std::string, double> angle_rad_by_stop;
  for (const TextLine& line : SplitLines(*text)) {
    const std::vector<std::string_view> fields = SplitFields(line.text.substr(0, line.text.find('#')));
    if (fields.empty()) continue;
    const std::string where = fmt::format("{} line {}", path.string(), line.number);
    if (fields.size() != 2)
      return Fail(ErrorCode::kBadInput, "{}: has {} fields, a stop and its angle in degrees are needed", where,
                  fields.size());
    const Result<std::vector<double>> angle_deg = ParseNumbers({&fields[1], 1}, where);
    if (!angle_deg) return Fail(angle_deg.error());
    if (!angle_rad_by_stop.emplace(fields[0], kRadPerDeg * angle_deg->front()).second)
      return Fail(ErrorCode::kBadInput, "{}: the stop '{}' is there twice", where, fields[0]);
  }
  return angle_rad_by_stop;
}

}  // namespace

void SortStops(std::vector<std::string>& ids) {
  const bool numbers = AllNumbers(ids);
  std::sort(ids.begin(), ids.end(), [numbers](const std::string& a, const std::string& b) {
    const int number_a = numbers ? *NumberOf(a) : 0, number_b = numbers ? *NumberOf(b) : 0;
    return number_a != number_b ? number_a < number_b : a < b;
  });
}

Result<std::map<std::string, double>> StopAngles(const std::string& angles_deg, const std::vector<std::string>& ids) {
  const auto start_and_step = StartAndStep(angles_deg);
  if (!start_and_step) {
    const auto angle_rad_by_stop = AnglesFromFile(angles_deg);
    if (!angle_rad_by_stop) return angle_rad_by_stop;
    for (const std::string& id : ids) {
      if (!angle_rad_by_stop->contains(id))
        return Fail(ErrorCode::kBadInput, "{}: has no angle for stop '{}'", angles_deg, id);
    }
    return angle_rad_by_stop;
  }
  if (Result<void> whole = CheckNoGap(ids); !whole) return Fail(whole.error());
  std::map<std::string, double> angle_rad_by_stop;
  for (std::size_t i = 0; i < ids.size(); ++i)
    angle_rad_by_stop[ids[i]] = kRadPerDeg * ((*start_and_step)[0] + static_cast<double>(i) * (*start_and_step)[1]);
  return angle_rad_by_stop;
}

}  // namespace rigcal
