#include "drivers/arm/pose_line.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <vector>

#include "drivers/line_connection.h"

namespace rigcal {
namespace {

constexpr std::size_t kLongestName = 64;
constexpr double kReach_m = 20;  ///< beyond the longest arms on rails; a pose in millimetres is beyond it
constexpr std::array kNumbers = {"x", "y", "z", "qw", "qx", "qy", "qz"};

std::vector<std::string_view> WordsOf(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlank, end);
  }
  return words;
}

bool FilesCanHold(std::string_view name) {
  return name.size() <= kLongestName && std::ranges::all_of(name, [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.';
         });
}

std::optional<double> NumberOf(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace

Result<RecordedStop> ParsePose(std::string_view line) {
  const std::vector<std::string_view> words = WordsOf(line);
  if (words.size() != 1 + kNumbers.size()) {
    return Fail(ErrorCode::kBadInput, "a pose is K x y z qw qx qy qz, 8 words, not {}", words.size());
  }
  const std::string id(words.front());
  if (!FilesCanHold(id)) {
    return Fail(ErrorCode::kBadInput,
                "'{}' cannot be the name of a stop: it is at most {} letters, digits, '.', '_' and '-'", OnOneLine(id),
                kLongestName);
  }
  std::array<double, kNumbers.size()> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::optional<double> number = NumberOf(words[1 + i]);
    if (!number) {
      return Fail(ErrorCode::kBadInput, "the {} of pose '{}' is '{}', which is not a number", kNumbers[i], id,
                  OnOneLine(std::string(words[1 + i])));
    }
    numbers[i] = *number;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(numbers[i]) <= kReach_m) continue;
    return Fail(ErrorCode::kBadInput, "the {} of pose '{}' is {} m, the limit is {} m; poses are in metres",
                kNumbers[i], id, numbers[i], kReach_m);
  }
  const auto [x, y, z, qw, qx, qy, qz] = numbers;
  const Eigen::Quaterniond rotation(qw, qx, qy, qz);
  if (!(std::abs(rotation.norm() - 1) <= kUnitTolerance)) {
    return Fail(ErrorCode::kBadInput, "the quaternion of pose '{}' has the length {:.6f}, 1 +- {} is allowed", id,
                rotation.norm(), kUnitTolerance);
  }
  const Rigid3d base_from_flange{rotation.normalized(), {x, y, z}};
  return RecordedStop{
      .id = id, .base_from_flange_commanded = base_from_flange, .base_from_flange_reported = base_from_flange};
}

std::string StopNamed(std::string_view line) {
  const std::vector<std::string_view> words = WordsOf(line);
  return words.empty() || !FilesCanHold(words.front()) ? "-" : std::string(words.front());
}

}  // namespace rigcal
