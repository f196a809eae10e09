#include "sim_fixtures/linuxcnc/mdi_line.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace rigcal::sim {
namespace {

constexpr double kSecondsPerMinute = 60, kMmPerInch = 25.4;
constexpr std::string_view kConfigured = "XZC";
/// MAX_VELOCITY of the axes X to C, millimetres or degrees a second.
constexpr MdiPosition kFastest = {200, 200, 200, 90, 90, 90};
constexpr MdiPosition kLeast = {-1000, 0, -10, 0, 0, -99999}, kMost = {1000, 0, 2000, 0, 0, 99999};

bool Linear(std::size_t axis) {
  return axis < 3;
}

/// "Bad character 'y' used": of a letter that the machine has not.
tl::unexpected<Error> BadCharacter(char letter) {
  return Fail(ErrorCode::kBadInput, "Bad character '{}' used",
              static_cast<char>(std::tolower(static_cast<unsigned char>(letter))));
}

Result<void> TakeG(double number, MdiModes& modes) {
  if (number == 0 || number == 1) modes.rapid = number == 0;
  if (number == 20 || number == 21) modes.inches = number == 20;
  if (number == 90 || number == 91) modes.relative = number == 91;
  for (const double known : {0.0, 1.0, 4.0, 20.0, 21.0, 53.0, 90.0, 91.0, 94.0}) {
    if (number == known) return {};
  }
  return Fail(ErrorCode::kBadInput, "Unknown g code used");
}

Result<MdiMotion> MotionTo(const MdiPosition& target, const MdiPosition& from, const MdiModes& modes) {
  MdiMotion motion{.target = target};
  double linear = 0, angular = 0;
  for (std::size_t axis = 0; axis < target.size(); ++axis) {
    if (kConfigured.find(kMdiLetters[axis]) == std::string_view::npos) continue;
    if (target[axis] < kLeast[axis] || target[axis] > kMost[axis]) {
      return Fail(ErrorCode::kBadInput, "Linear move on line 0 would exceed {}'s {} limit", kMdiLetters[axis],
                  target[axis] < kLeast[axis] ? "negative" : "positive");
    }
    const double way = std::abs(target[axis] - from[axis]);
    double& path = Linear(axis) ? linear : angular;
    path = std::hypot(path, way);
    motion.duration_s = std::max(motion.duration_s, way / kFastest[axis]);
  }
  const double path = linear > 0 ? linear : angular;  // what F is the speed along
  if (modes.rapid || path == 0) return motion;
  if (modes.feed_per_min <= 0) return Fail(ErrorCode::kBadInput, "Cannot do G1 with zero feed rate");
  motion.duration_s = std::max(motion.duration_s, path / modes.feed_per_min * kSecondsPerMinute);
  return motion;
}

}  // namespace

Result<std::optional<MdiMotion>> ReadMdiLine(std::string_view text, const MdiPosition& from, MdiModes& modes) {
  MdiPosition target = from;
  bool moves = false;
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (text.empty()) break;
    const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
    text.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc()) return Fail(ErrorCode::kBadInput, "Bad number format");
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    const std::size_t axis = kMdiLetters.find(letter);
    if (letter == 'G') {
      if (Result<void> taken = TakeG(number, modes); !taken) return Fail(taken.error());
    } else if (letter == 'F') {
      modes.feed_per_min = number * (modes.inches ? kMmPerInch : 1);
    } else if (axis != std::string_view::npos && kConfigured.find(letter) != std::string_view::npos) {
      const double value = number * (modes.inches && Linear(axis) ? kMmPerInch : 1);
      target[axis] = modes.relative ? from[axis] + value : value;
      moves = true;
    } else if (letter != 'P') {
      return BadCharacter(letter);
    }
  }
  if (!moves) return std::nullopt;
  Result<MdiMotion> motion = MotionTo(target, from, modes);
  if (!motion) return Fail(motion.error());
  return *motion;
}

}  // namespace rigcal::sim
