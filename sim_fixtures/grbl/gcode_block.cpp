#include "sim_fixtures/grbl/gcode_block.h"

#include <charconv>
#include <cmath>

namespace rigcal::sim {
namespace {

constexpr int kNoLetter = 1, kBadNumber = 2, kNegative = 4, kUnsupportedWord = 20, kRepeatedWord = 25;  // GRBL's errors
constexpr int kTenths = 10;  ///< G38.2 and the like: words are compared in tenths

bool TakeG(int tenths, GcodeBlock& block) {
  switch (tenths) {
    case 0:
    case 1 * kTenths:
      block.motion = tenths / kTenths;
      return true;
    case 10 * kTenths:
      block.offset_l = 0;
      return true;
    case 20 * kTenths:
    case 21 * kTenths:
      block.inches = tenths == 20 * kTenths;
      return true;
    case 53 * kTenths:
      block.in_machine = true;
      return true;
    case 90 * kTenths:
    case 91 * kTenths:
      block.relative = tenths == 91 * kTenths;
      return true;
    case 92 * kTenths:
      block.sets_offset = true;
      return true;
    case 17 * kTenths:
    case 54 * kTenths:
    case 94 * kTenths:
      return true;  // the only plane, coordinate system and feed mode here
    default:
      return false;
  }
}

/// GRBL's error, 0 for none.
int TakeWord(char letter, double value, GcodeBlock& block) {
  if (letter >= 'X' && letter <= 'Z') {
    std::optional<double>& axis = block.axes[letter - 'X'];
    if (axis) return kRepeatedWord;
    axis = value;
    return 0;
  }
  switch (letter) {
    case 'G':
      return TakeG(static_cast<int>(std::lround(value * kTenths)), block) ? 0 : kUnsupportedWord;
    case 'F':
      if (value < 0) return kNegative;
      block.feed_per_min = value;
      return 0;
    case 'L':
      if (!block.offset_l) return kUnsupportedWord;
      block.offset_l = static_cast<int>(value);
      return 0;
    case 'P':
    case 'N':
    case 'S':
      return 0;
    case 'M':
      return value == 5 || value == 9 ? 0 : kUnsupportedWord;
    default:
      return kUnsupportedWord;
  }
}

}  // namespace

std::variant<GcodeBlock, int> ParseGcode(std::string_view line) {
  GcodeBlock block;
  while (!line.empty()) {
    const char letter = line.front();
    if (letter < 'A' || letter > 'Z') return kNoLetter;
    double value = 0;
    const auto [end, failure] = std::from_chars(line.data() + 1, line.data() + line.size(), value);
    if (failure != std::errc{}) return kBadNumber;
    if (const int error = TakeWord(letter, value, block); error != 0) return error;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  }
  return block;
}

}  // namespace rigcal::sim
