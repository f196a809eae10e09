// What a controller does with the bytes and lines that it receives; its motion is in grbl_machine.cpp.
#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <limits>
#include <utility>

#include "sim_fixtures/grbl/grbl_machine.h"

namespace rigcal::sim {
namespace {

constexpr double kAtMaxRate = std::numeric_limits<double>::infinity();
constexpr unsigned char kReset = 0x18, kDoor = 0x84, kJogCancel = 0x85, kFirstRealtime = 0x80;
// GRBL's errors
constexpr int kUnknownSystem = 3, kOnlyIdle = 8, kLocked = 9, kTooLong = 11, kJogTarget = 15, kBadJog = 16;
constexpr int kUnsupportedWord = 20, kNoFeed = 22, kNoAxes = 26;

}  // namespace

void GrblMachine::SayError(int number) {
  Say(fmt::format("error:{}", number));
}

void GrblMachine::Take(char c) {
  const auto code = static_cast<unsigned char>(c);
  if (c == '?' || c == '!' || c == '~' || code == kReset || code >= kFirstRealtime) {
    TakeRealtime(c);
  } else if (received_.size() < kReceiveBuffer) {  // what does not fit is lost, as on the board
    received_.push_back(c);
    TakeLines();
  }
}

void GrblMachine::TakeRealtime(char c) {
  const auto code = static_cast<unsigned char>(c);
  if (code == kReset) return Reset();
  if (waits_for_reset_) return;
  if (c == '?') Report();
  if (c == '!') Hold();
  if (c == '~') Resume();
  if (code == kDoor) SetDoor(true);
  if (code == kJogCancel && state_ == State::kJog) Hold();
}

void GrblMachine::TakeLines() {
  while (!waits_for_reset_ && state_ != State::kHome) {
    const std::size_t end = received_.find_first_of("\r\n");
    std::string line;
    for (const char c : received_.substr(0, end)) {
      if (c != ' ') line.push_back(static_cast<char>(std::toupper(static_cast<unsigned char>(c))));
    }
    if (end == std::string::npos || Waits(line)) return;
    received_.erase(0, end + 1);
    if (log_ != nullptr) *log_ += line + '\n';
    Execute(line);
  }
}

/// A line that moves waits for room in the planner.
bool GrblMachine::Waits(const std::string& line) const {
  return motion_.Full() && (line.starts_with("$J=") || line.starts_with('G'));
}

void GrblMachine::Execute(const std::string& line) {
  if (line.size() >= kLongestLine) return SayError(kTooLong);
  if (line.empty()) return Say("ok");
  if (line.front() == '$') return ExecuteSystem(line);
  if (state_ == State::kAlarm || state_ == State::kJog) return SayError(kLocked);
  const auto block = ParseGcode(line);
  if (const int* error = std::get_if<int>(&block)) return SayError(*error);
  ExecuteGcode(std::get<GcodeBlock>(block));
}

void GrblMachine::ExecuteSystem(const std::string& line) {
  if (line.starts_with("$J=")) return ExecuteJog(std::string_view(line).substr(3));
  if (line == "$G") {
    Say(fmt::format("[GC:G{} G54 G17 G{} G{} G94 M5 M9 T0 F{:.0f} S0]", motion_mode_, inches_ ? 20 : 21,
                    relative_ ? 91 : 90, feed_per_min_));
    return Say("ok");
  }
  if (line == "$") {
    Say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]");
    return Say("ok");
  }
  if (state_ != State::kIdle && state_ != State::kAlarm) return SayError(kOnlyIdle);
  if (line == "$H") return StartHoming();
  if (line == "$X") {
    if (state_ == State::kAlarm) Say("[MSG:Caution: Unlocked]");
    state_ = State::kIdle;
    return Say("ok");
  }
  if (line == "$I") {
    Say("[VER:1.1h.20190825:]");
    Say("[OPT:V,15,128]");
    return Say("ok");
  }
  if (line == "$N") {
    Say(faults_.startup == 0 ? "$N0=" : fmt::format("$N0=G91G1X{:.3f}F60", faults_.startup));
    Say("$N1=");
    return Say("ok");
  }
  if (line == "$#") {
    SayValues("G54", offset_);
    SayValues("G92", g92_);
    return Say("ok");
  }
  if (line != "$$") return ExecuteSetting(line);
  for (const auto& [number, value] : settings_) {
    Say(number < 100 && value == static_cast<int>(value) ? fmt::format("${}={:.0f}", number, value)
                                                         : fmt::format("${}={:.3f}", number, value));
  }
  Say("ok");
}

void GrblMachine::SayValues(const char* name, const AxisValues& values) {
  Say(fmt::format("[{}:{:.3f},{:.3f},{:.3f}]", name, values[0], values[1], values[2]));
}

void GrblMachine::ExecuteSetting(const std::string& line) {
  int number = 0;
  double value = 0;
  const char *begin = line.data() + 1, *end = line.data() + line.size();
  const auto [equals, no_number] = std::from_chars(begin, end, number);
  if (no_number != std::errc{} || equals == end || *equals != '=' || !settings_.contains(number)) {
    return SayError(kUnknownSystem);
  }
  if (std::from_chars(equals + 1, end, value).ec != std::errc{}) return SayError(2);
  settings_[number] = value;
  Say("ok");
}

void GrblMachine::ExecuteJog(std::string_view line) {
  if (state_ != State::kIdle && state_ != State::kJog) return SayError(state_ == State::kAlarm ? kLocked : kOnlyIdle);
  const auto parsed = ParseGcode(line);
  if (const int* error = std::get_if<int>(&parsed)) return SayError(*error);
  const GcodeBlock& block = std::get<GcodeBlock>(parsed);
  if (block.motion || block.sets_offset || block.offset_l) return SayError(kBadJog);
  if (!block.HasAxes()) return SayError(kNoAxes);
  if (!block.feed_per_min || *block.feed_per_min == 0) return SayError(kNoFeed);
  AxisValues target = TargetOf(block, block.relative.value_or(relative_), block.inches.value_or(inches_));
  if (BeyondTravel(target)) return SayError(kJogTarget);
  target[0] += faults_.miss;
  Move(target, *block.feed_per_min, State::kJog);
  Say("ok");
}

void GrblMachine::SetOffset(const GcodeBlock& block) {
  const AxisValues position = motion_.End();
  for (int axis = 0; axis < kNumGrblAxes; ++axis) {
    if (!block.axes[axis]) continue;
    if (block.sets_offset) g92_[axis] = position[axis] - offset_[axis] - *block.axes[axis];
    if (block.offset_l == 2) offset_[axis] = *block.axes[axis];
    if (block.offset_l == 20) offset_[axis] = position[axis] - g92_[axis] - *block.axes[axis];
  }
  reports_to_offset_ = 0;
}

void GrblMachine::ExecuteGcode(const GcodeBlock& block) {
  if (block.offset_l && *block.offset_l != 2 && *block.offset_l != 20) return SayError(kUnsupportedWord);
  relative_ = block.relative.value_or(relative_);
  inches_ = block.inches.value_or(inches_);
  motion_mode_ = block.motion.value_or(motion_mode_);
  feed_per_min_ = block.feed_per_min.value_or(feed_per_min_);
  if (block.sets_offset || block.offset_l) {
    SetOffset(block);
  } else if (block.HasAxes()) {
    if (motion_mode_ == 1 && feed_per_min_ == 0) return SayError(kNoFeed);
    const AxisValues target = TargetOf(block, relative_, inches_);
    if (BeyondTravel(target)) return Alarm(2, true);
    Move(target, motion_mode_ == 0 ? kAtMaxRate : feed_per_min_, State::kRun);
  }
  Say("ok");
}

}  // namespace rigcal::sim
