#include "drivers/grbl/grbl_protocol.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace rigcal {
namespace {

constexpr std::array<std::pair<GrblState, std::string_view>, 9> kStates = {{{GrblState::kIdle, "Idle"},
                                                                            {GrblState::kRun, "Run"},
                                                                            {GrblState::kJog, "Jog"},
                                                                            {GrblState::kHold, "Hold"},
                                                                            {GrblState::kAlarm, "Alarm"},
                                                                            {GrblState::kDoor, "Door"},
                                                                            {GrblState::kCheck, "Check"},
                                                                            {GrblState::kHome, "Home"},
                                                                            {GrblState::kSleep, "Sleep"}}};

constexpr std::array<std::string_view, 11> kAlarms = {"an alarm without a number",
                                                      "a limit switch was hit",
                                                      "the target is beyond the machine's travel",
                                                      "it was reset while it moved",
                                                      "the probe was not as expected before probing",
                                                      "the probe touched nothing",
                                                      "homing was ended by a reset",
                                                      "the safety door was opened while homing",
                                                      "homing did not get off the limit switch",
                                                      "homing did not find the limit switch",
                                                      "homing did not find the second limit switch"};

/// From the front of `text` up to `separator`, which goes too; all of it where there is none.
std::string_view TakeUntil(std::string_view& text, char separator) {
  const std::size_t end = text.find(separator);
  const std::string_view taken = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return taken;
}

template <typename T>
std::optional<T> NumberOf(std::string_view text) {
  T value{};
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

/// The first three of the values: some builds report more axes, which rigcal does not move.
std::optional<GrblPosition> PositionOf(std::string_view text) {
  GrblPosition position{};
  for (double& value : position) {
    const std::optional<double> number = NumberOf<double>(TakeUntil(text, ','));
    if (!number || !std::isfinite(*number)) return std::nullopt;
    value = *number;
  }
  return position;
}

bool ReadState(std::string_view text, GrblStatus& status) {
  const std::string_view name = TakeUntil(text, ':');
  const auto state = std::ranges::find(kStates, name, &std::pair<GrblState, std::string_view>::second);
  if (state == kStates.end()) return false;
  status.state = state->first;
  status.substate = NumberOf<int>(text);
  return true;
}

/// Fields that are not needed (Bf, FS, Ov, Ln, A) are passed over.
bool ReadField(std::string_view text, GrblStatus& status) {
  const std::string_view name = TakeUntil(text, ':');
  if (name == "Pn") status.pins = text;
  if (name == "MPos") return (status.in_machine = PositionOf(text)).has_value();
  if (name == "WPos") return (status.in_work = PositionOf(text)).has_value();
  if (name == "WCO") return (status.work_in_machine = PositionOf(text)).has_value();
  return true;
}

std::optional<GrblStatus> StatusOf(std::string_view line) {
  if (line.size() < 2 || line.front() != '<' || line.back() != '>') return std::nullopt;
  std::string_view fields = line.substr(1, line.size() - 2);
  GrblStatus status;
  if (!ReadState(TakeUntil(fields, '|'), status)) return std::nullopt;
  while (!fields.empty()) {
    if (!ReadField(TakeUntil(fields, '|'), status)) return std::nullopt;
  }
  if (!status.in_machine && !status.in_work) return std::nullopt;  // every whole report has one
  return status;
}

/// "Grbl 1.1h ['$' for help]"; relatives say "GrblHAL 1.1f [...".
std::optional<std::string> BannerVersionOf(std::string_view line) {
  if (!line.starts_with("Grbl") || line.find('[') == std::string_view::npos) return std::nullopt;
  TakeUntil(line, ' ');
  return std::string(TakeUntil(line, ' '));
}

}  // namespace

bool GrblStatus::AtRest() const {
  switch (state) {
    case GrblState::kIdle:
    case GrblState::kAlarm:
    case GrblState::kCheck:
    case GrblState::kSleep:
      return true;
    case GrblState::kHold:
      return substate == 0;
    case GrblState::kDoor:
      return substate == 0 || substate == 1;
    case GrblState::kRun:
    case GrblState::kJog:
    case GrblState::kHome:
      break;
  }
  return false;
}

GrblLine ParseGrblLine(std::string_view line) {
  GrblLine parsed{.text = std::string(line)};
  const auto numbered = [&](GrblLineKind kind, std::string_view prefix) {
    parsed.kind = kind;
    parsed.number = NumberOf<int>(line.substr(prefix.size())).value_or(0);
    return parsed;
  };
  if (line == "ok") parsed.kind = GrblLineKind::kOk;
  if (line.starts_with("error:")) return numbered(GrblLineKind::kError, "error:");
  if (line.starts_with("ALARM:")) return numbered(GrblLineKind::kAlarm, "ALARM:");
  if (const auto version = BannerVersionOf(line)) {
    parsed.kind = GrblLineKind::kBanner;
    parsed.text = *version;
  }
  if (auto status = StatusOf(line)) {
    parsed.kind = GrblLineKind::kStatus;
    parsed.status = std::move(*status);
  }
  if (line.starts_with('$')) {
    std::string_view value = line.substr(1);
    const std::optional<int> number = NumberOf<int>(TakeUntil(value, '='));
    if (number) {
      parsed.kind = GrblLineKind::kSetting;
      parsed.number = *number;
      parsed.text = value;
    }
  }
  return parsed;
}

std::string_view GrblAlarmMeaning(int number) {
  return number > 0 && number < static_cast<int>(kAlarms.size()) ? kAlarms[number] : kAlarms[0];
}

std::string_view GrblErrorMeaning(int number) {
  switch (number) {
    case 5:
      return "homing is not enabled";
    case 8:
      return "only valid while idle";
    case 9:
      return "locked by an alarm or a jog";
    case 11:
      return "the line is too long";
    case 13:
      return "the safety door is open";
    case 15:
      return "the target is beyond the machine's travel";
    case 20:
      return "the command is not supported";
    case 22:
      return "the feed rate is missing";
    default:
      return "the command was refused";
  }
}

std::string_view NameOf(GrblState state) {
  return std::ranges::find(kStates, state, &std::pair<GrblState, std::string_view>::first)->second;
}

void LineSplitter::Add(std::string_view bytes) {
  for (const char c : bytes) {
    if (c == '\n' || c == '\r') {
      if (!begun_.empty() && !too_long_) lines_.push_back(std::move(begun_));
      begun_.clear();
      too_long_ = false;
    } else if (begun_.size() >= kLongestLine) {
      too_long_ = true;
    } else {
      begun_.push_back(c);
    }
  }
}

std::optional<std::string> LineSplitter::Next() {
  if (lines_.empty()) return std::nullopt;
  std::string line = std::move(lines_.front());
  lines_.pop_front();
  return line;
}

}  // namespace rigcal
