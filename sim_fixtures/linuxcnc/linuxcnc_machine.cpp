#include "sim_fixtures/linuxcnc/linuxcnc_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rigcal::sim {
namespace {

constexpr int kSomebodyElse = -2;  ///< a connection that none of the simulator's has the number of

}  // namespace

LinuxcncMachine::LinuxcncMachine(Clock& clock) : clock_(clock), at_s_(clock.NowS()) {}

void LinuxcncMachine::Elapse() {
  AdvanceTo(clock_.NowS());
}

double LinuxcncMachine::Position(char axis) const {
  return at_[kMdiLetters.find(axis)];
}

void LinuxcncMachine::SetPosition(char axis, double value) {
  at_[kMdiLetters.find(axis)] = value;
}

bool LinuxcncMachine::Homed() const {
  return std::ranges::all_of(homed_, [](bool homed) { return homed; });
}

void LinuxcncMachine::SetEmergencyStop(bool on, bool held) {
  Elapse();
  emergency_stop_ = on;
  held_ = held;
  if (on) SwitchOff();
}

void LinuxcncMachine::SwitchOff() {
  StopMotion();
  power_ = false;
}

void LinuxcncMachine::StopMotion() {
  moves_.clear();
  paused_ = homing_ = false;
}

void LinuxcncMachine::AdvanceTo(double now_s) {
  const bool runs = !moves_.empty() && !paused_;
  const double trouble_s = moving_since_s_ + faults_.in_motion_after_s;
  const bool trouble = runs && faults_.in_motion && trouble_s <= now_s;
  const double until_s = trouble ? std::max(at_s_, trouble_s) : now_s;
  double left_s = until_s - at_s_;
  at_s_ = std::max(at_s_, until_s);
  while (runs && !faults_.stuck && !moves_.empty() && left_s > 0) {
    Move& move = moves_.front();
    const double share = std::min(1.0, left_s / move.left_s);
    for (std::size_t axis = 0; axis < at_.size(); ++axis) at_[axis] += (move.target[axis] - at_[axis]) * share;
    left_s -= move.left_s;
    if (left_s < 0) {
      move.left_s = -left_s;
    } else {
      at_ = move.target;
      moves_.pop_front();
    }
  }
  AdvanceHoming(at_s_);
  if (!trouble) return;
  if (!moves_.empty()) MakeTrouble();
  AdvanceTo(now_s);
}

/// One joint after the other, each to its zero at the end of its time.
void LinuxcncMachine::AdvanceHoming(double now_s) {
  while (homing_ && now_s >= homing_until_s_) {
    std::size_t joint = 0;
    while (joint < homed_.size() && (homed_[joint] || (faults_.no_sequence && joint == 1))) ++joint;
    if (joint == homed_.size()) {
      homing_ = false;
      return;
    }
    if (faults_.no_home) {
      messages_.push_back(fmt::format("j{} end of move in home state 7", joint));
      homing_ = false;
      return;
    }
    homed_[joint] = true;
    at_[kMdiLetters.find("XZC"[joint])] = 0;
    homing_until_s_ += kHoming_s;
  }
}

void LinuxcncMachine::MakeTrouble() {
  switch (*std::exchange(faults_.in_motion, std::nullopt)) {
    case LinuxcncTrouble::kEmergencyStop:
      return SetEmergencyStop(true, true);
    case LinuxcncTrouble::kLimit:
      at_limit_ = true;
      messages_.emplace_back("joint 2 on limit switch error");
      return SwitchOff();
    case LinuxcncTrouble::kPowerOff:
      return SwitchOff();
    case LinuxcncTrouble::kPause:
      paused_ = true;
      return;
    case LinuxcncTrouble::kTakenOver:
      enabled_ = kSomebodyElse;
      return StopMotion();
    case LinuxcncTrouble::kGone:
      gone_ = true;
      [[fallthrough]];
    case LinuxcncTrouble::kCut:
      cut_ = true;
      return;
  }
}

void LinuxcncMachine::RunMdi(const std::string& text) {
  if (!Homed()) return messages_.emplace_back("Can't issue MDI command when not homed"), void();
  const MdiPosition from = moves_.empty() ? at_ : moves_.back().target;
  Result<std::optional<MdiMotion>> motion = ReadMdiLine(text, from, modes_);
  if (!motion) return messages_.push_back(motion.error().message), void();
  if (!*motion || (*motion)->target == from) return;
  (*motion)->target[kMdiLetters.find('C')] += faults_.miss;
  if (moves_.empty()) moving_since_s_ = at_s_;
  moves_.push_back({(*motion)->target, std::max((*motion)->duration_s, 1e-3)});
}

}  // namespace rigcal::sim
