#include "sim_fixtures/grbl/grbl_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rigcal::sim {
namespace {

constexpr double kSecondsPerMinute = 60, kMmPerInch = 25.4;
constexpr int kReportMask = 10, kInches = 13, kSoftLimits = 20, kHomingCycle = 22, kPullOff = 27;  // settings
constexpr int kMaxRate = 110, kMaxTravel = 130;
constexpr int kReportsBetweenOffsets = 10;
constexpr double kStartupFeed_per_min = 60;

/// GRBL's own values when it is delivered, with homing, for a table and two axes of a metre.
std::map<int, double> Delivered() {
  return {{0, 10},    {1, 25},    {2, 0},      {3, 0},      {4, 0},      {5, 0},      {6, 0},
          {10, 1},    {11, 0.01}, {12, 0.002}, {13, 0},     {20, 0},     {21, 1},     {22, 1},
          {23, 0},    {24, 25},   {25, 500},   {26, 250},   {27, 1},     {30, 1000},  {31, 0},
          {32, 0},    {100, 250}, {101, 250},  {102, 250},  {110, 1800}, {111, 1800}, {112, 1800},
          {120, 100}, {121, 100}, {122, 100},  {130, 1000}, {131, 1000}, {132, 1000}};
}

}  // namespace

GrblMachine::GrblMachine(Clock& clock) : clock_(clock), settings_(Delivered()), at_s_(clock.NowS()) {}

std::string GrblMachine::PowerOn() {
  out_.clear();
  motion_.Clear();
  motion_.SetPosition({});
  state_ = settings_[kHomingCycle] != 0 ? State::kAlarm : State::kIdle;
  Boot();
  return std::exchange(out_, {});
}

std::string GrblMachine::Receive(std::string_view bytes) {
  AdvanceTo(clock_.NowS());
  for (const char c : bytes) Take(c);
  TakeLines();
  std::string said = std::exchange(out_, {});
  return faults_.silent ? "" : said;
}

std::string GrblMachine::Elapse() {
  return Receive("");
}

void GrblMachine::SetDoor(bool open) {
  AdvanceTo(clock_.NowS());
  door_open_ = open;
  if (!open) return;
  Say("[MSG:Check Door]");
  if (state_ == State::kHome) return Alarm(7, false), Boot();
  state_ = State::kDoor;
}

void GrblMachine::SetWorkOffset(const AxisValues& work_in_machine) {
  offset_ = work_in_machine;
  reports_to_offset_ = 0;
}

bool GrblMachine::Moving() const {
  const bool runs = (state_ == State::kRun || state_ == State::kJog) && !motion_.Empty();
  return runs || state_ == State::kHome;
}

AxisValues GrblMachine::PositionInWork() const {
  AxisValues position = motion_.Position();
  for (int axis = 0; axis < kNumGrblAxes; ++axis) position[axis] -= offset_[axis] + g92_[axis];
  return position;
}

void GrblMachine::AdvanceTo(double now_s) {
  const bool runs = state_ == State::kRun || state_ == State::kJog;
  const double trouble_s = moving_since_s_ + faults_.in_motion_after_s;
  const bool trouble = runs && faults_.in_motion && trouble_s <= now_s;
  const double until_s = trouble ? std::max(at_s_, trouble_s) : now_s;
  if (runs && !faults_.stuck) motion_.Advance(until_s - at_s_);
  at_s_ = std::max(at_s_, until_s);
  if (trouble && !motion_.Empty()) {
    MakeTrouble();
    return AdvanceTo(now_s);
  }
  at_s_ = now_s;
  if (runs && !faults_.stuck) motion_.Advance(now_s - until_s);
  if ((state_ == State::kRun || state_ == State::kJog) && motion_.Empty()) state_ = State::kIdle;
  if (state_ == State::kHome && now_s >= homed_at_s_) EndHoming();
}

void GrblMachine::MakeTrouble() {
  switch (*std::exchange(faults_.in_motion, std::nullopt)) {
    case GrblTrouble::kLimitSwitch:
      return Alarm(1, true);
    case GrblTrouble::kDoor:
      return SetDoor(true);
    case GrblTrouble::kFeedHold:
      motion_.Clear();
      state_ = State::kHold;
      return;
    case GrblTrouble::kPowerCut:
      out_ += PowerOn();
      return;
    case GrblTrouble::kLineCut:
      line_cut_ = true;
      return;
  }
}

void GrblMachine::Hold() {
  if (state_ == State::kJog) {  // a jog is cancelled
    motion_.Clear();
    state_ = State::kIdle;
  } else if (state_ == State::kRun || state_ == State::kIdle) {
    state_ = State::kHold;
  }
}

void GrblMachine::Resume() {
  if (state_ == State::kHold || (state_ == State::kDoor && !door_open_)) {
    moving_since_s_ = at_s_;
    state_ = motion_.Empty() ? State::kIdle : State::kRun;
  }
}

void GrblMachine::Reset() {
  if (state_ == State::kHome) {
    Alarm(6, false);
  } else if (Moving()) {
    Alarm(3, false);
  }
  if (state_ != State::kAlarm) state_ = State::kIdle;
  Boot();
}

void GrblMachine::Boot() {
  motion_.Clear();
  received_.clear();
  waits_for_reset_ = relative_ = inches_ = false;
  motion_mode_ = 0;
  feed_per_min_ = 0;
  g92_ = {};
  reports_to_offset_ = 0;
  out_ += "\r\n";
  Say("Grbl 1.1h ['$' for help]");
  if (state_ == State::kAlarm) return Say("[MSG:'$H'|'$X' to unlock]");
  if (!door_open_) return RunStartup();
  Say("[MSG:Check Door]");
  state_ = State::kDoor;
}

void GrblMachine::RunStartup() {
  const AxisValues from = motion_.Position();
  if (faults_.startup != 0) {
    Move({from[0] + faults_.startup, from[1], from[2]}, kStartupFeed_per_min, State::kRun);
  }
}

void GrblMachine::Alarm(int number, bool waits_for_reset) {
  motion_.Clear();
  state_ = State::kAlarm;
  Say(fmt::format("ALARM:{}", number));
  waits_for_reset_ = waits_for_reset;
  if (waits_for_reset) Say("[MSG:Reset to continue]");
}

void GrblMachine::StartHoming() {
  if (settings_[kHomingCycle] == 0) return SayError(5);
  if (state_ != State::kIdle && state_ != State::kAlarm) return SayError(8);
  state_ = State::kHome;
  homed_at_s_ = at_s_ + kHoming_s;
}

void GrblMachine::EndHoming() {
  if (faults_.no_home) {
    Alarm(9, false);
    return Boot();
  }
  const double at = -settings_[kPullOff];
  motion_.SetPosition({at, at, at});
  state_ = State::kIdle;
  RunStartup();
  Say("ok");
}

void GrblMachine::Report() {
  if (waits_for_reset_ || state_ == State::kHome) return;  // GRBL does not answer then
  const bool in_machine = (static_cast<int>(settings_[kReportMask]) & 1) != 0;
  const AxisValues position = in_machine ? motion_.Position() : PositionInWork();
  const double scale = settings_[kInches] != 0 ? 1 / kMmPerInch : 1;
  out_ += fmt::format("<{}|{}:{:.3f},{:.3f},{:.3f}", StateName(), in_machine ? "MPos" : "WPos", position[0] * scale,
                      position[1] * scale, position[2] * scale);
  if ((static_cast<int>(settings_[kReportMask]) & 2) != 0) {
    out_ += fmt::format("|Bf:{},{}", motion_.NumFree(), kReceiveBuffer - received_.size());
  }
  out_ += fmt::format("|FS:{:.0f},0", Moving() ? feed_per_min_ : 0);
  if (door_open_) out_ += "|Pn:D";
  if (reports_to_offset_-- == 0) {
    reports_to_offset_ = kReportsBetweenOffsets;
    out_ += fmt::format("|WCO:{:.3f},{:.3f},{:.3f}", (offset_[0] + g92_[0]) * scale, (offset_[1] + g92_[1]) * scale,
                        (offset_[2] + g92_[2]) * scale);
  }
  Say(">");
}

std::string GrblMachine::StateName() const {
  switch (state_) {
    case State::kIdle:
      return "Idle";
    case State::kRun:
      return "Run";
    case State::kJog:
      return "Jog";
    case State::kHold:
      return "Hold:0";
    case State::kAlarm:
      return "Alarm";
    case State::kDoor:
      return door_open_ ? "Door:1" : "Door:0";
    case State::kHome:
      break;
  }
  return "Home";
}

AxisValues GrblMachine::TargetOf(const GcodeBlock& block, bool relative, bool inches) const {
  AxisValues target = motion_.End();
  for (int axis = 0; axis < kNumGrblAxes; ++axis) {
    if (!block.axes[axis]) continue;
    const double value = *block.axes[axis] * (inches ? kMmPerInch : 1);
    const double origin = relative ? target[axis] : block.in_machine ? 0 : offset_[axis] + g92_[axis];
    target[axis] = origin + value;
  }
  return target;
}

/// With soft limits the machine's space is from -travel to 0 on each axis.
bool GrblMachine::BeyondTravel(const AxisValues& target) const {
  if (settings_.at(kSoftLimits) == 0) return false;
  for (int axis = 0; axis < kNumGrblAxes; ++axis) {
    if (target[axis] > 0 || target[axis] < -settings_.at(kMaxTravel + axis)) return true;
  }
  return false;
}

void GrblMachine::Move(const AxisValues& target, double feed_per_min, State state) {
  const AxisValues from = motion_.End();
  const double way = WayBetween(from, target);
  double rate_per_min = feed_per_min;
  for (int axis = 0; axis < kNumGrblAxes; ++axis) {  // no axis beyond its own rate
    const double share = way > 0 ? std::abs(target[axis] - from[axis]) / way : 0;
    if (share > 0) rate_per_min = std::min(rate_per_min, settings_[kMaxRate + axis] / share);
  }
  motion_.Add(target, rate_per_min / kSecondsPerMinute);
  if (motion_.Empty() || state_ == state) return;
  state_ = state;
  moving_since_s_ = at_s_;
}

}  // namespace rigcal::sim
