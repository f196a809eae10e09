#include "drivers/linuxcnc/linuxcnc_positioner.h"

#include <algorithm>
#include <utility>

#include "core/base/joined.h"
#include "drivers/driver.h"
#include "drivers/linuxcnc/mdi_move.h"

namespace rigcal {
namespace {

constexpr double kPoll_s = 0.05;                     ///< between two looks at a machine that moves
constexpr double kPowerOn_s = 5;                     ///< drives that answer later have a fault
constexpr double kHomeStill_s = 2;                   ///< homing pauses for less between its stages and joints
constexpr std::string_view kNotHomed = "not homed";  ///< in its answer to a move by MDI
constexpr int kLeastPort = 1;

std::string At(const PositionerSettings& settings) {
  return "linuxcnc: " + settings.address;
}

Result<void> CheckAxes(const PositionerSettings& settings) {
  std::string used;
  for (const AxisSettings& axis : settings.axes) {
    const bool turns = axis.unit == AxisUnit::kRadian;
    const std::string_view letters = turns ? "ABC" : "XYZ";
    if (axis.device_letter.size() != 1 || letters.find(axis.device_letter) == std::string_view::npos) {
      return Fail(ErrorCode::kBadInput, "{}: the axis '{}', which {}, has the letter '{}', it must be one of {}",
                  At(settings), axis.name, turns ? "turns" : "does not turn", axis.device_letter,
                  turns ? "A, B and C" : "X, Y and Z, whose positions linuxcncrsh tells");
    }
    if (used.find(axis.device_letter) != std::string::npos) {
      return Fail(ErrorCode::kBadInput, "{}: the axis '{}' has the letter {} of another one", At(settings), axis.name,
                  axis.device_letter);
    }
    used += axis.device_letter;
  }
  if (used.empty()) return Fail(ErrorCode::kBadInput, "{}: there is no axis to move", At(settings));
  return {};
}

/// The joints whose word is not "OK", of "OK OK MAXHARD".
std::vector<std::string> JointsNotOk(std::string_view words) {
  std::vector<std::string> joints;
  for (int joint = 0; !words.empty(); ++joint) {
    const std::string_view word = words.substr(0, words.find(' '));
    words.remove_prefix(std::min(word.size() + 1, words.size()));
    if (word != "OK") joints.push_back(fmt::format("joint {}: {}", joint, word));
  }
  return joints;
}

}  // namespace

Result<std::unique_ptr<PositionerDevice>> LinuxcncPositioner::Open(const PositionerSettings& settings, Clock& clock,
                                                                   const std::stop_token& stop) {
  if (Result<void> checked = CheckAxes(settings); !checked) return Fail(checked.error());
  const std::optional<SocketAddress> address = ParseSocketAddress(settings.address, kLeastPort);
  if (!address) return Fail(ErrorCode::kBadInput, "{}: the address is not HOST:PORT", At(settings));
  Result<RshSession> session = RshSession::Open(*address, RshRole::kControl, clock, stop);
  if (!session) return Fail(session.error());
  return std::unique_ptr<PositionerDevice>(new LinuxcncPositioner(std::move(*session), settings, clock));
}

LinuxcncPositioner::LinuxcncPositioner(RshSession session, PositionerSettings settings, Clock& clock)
    : session_(std::move(session)), settings_(std::move(settings)), clock_(clock) {}

std::vector<double> LinuxcncPositioner::AxesAt(const RshPosition& at) const {
  std::vector<double> axes;
  for (const AxisSettings& axis : settings_.axes) {
    axes.push_back(AxisFromRsh(at[kRshAxisLetters.find(axis.device_letter)], axis.unit));
  }
  return axes;
}

tl::unexpected<Error> LinuxcncPositioner::Stopped(const Error& error) {
  rested_.reset();
  approached_ = false;
  const bool stands = session_.Stop();
  std::vector<std::string> names;
  for (const AxisSettings& axis : settings_.axes) names.push_back(fmt::format("'{}'", axis.name));
  return Fail(error.code, "{} (axis {}){}", error.message, Joined(names, ", "),
              stands ? "" : "; it was not seen to stop: a move under way goes on to its target");
}

Result<void> LinuxcncPositioner::Home(const std::stop_token& stop) {
  try {
    if (Result<void> homed = HomeAtRest(stop); !homed) return Stopped(homed.error());
    return {};
  } catch (...) {
    Halt();
    throw;
  }
}

Result<void> LinuxcncPositioner::HomeAtRest(const std::stop_token& stop) {
  if (Result<void> restored = session_.Restore(stop); !restored) return restored;
  if (Result<void> on = SwitchOn(stop); !on) return on;
  Result<bool> takes_moves = TakesMoves(stop);
  if (!takes_moves) return Fail(takes_moves.error());
  if (*takes_moves) return {};
  rested_.reset();
  approached_ = false;
  if (Result<void> set = session_.Set("mode manual", stop); !set) return set;
  if (Result<void> set = session_.Set("home -1", stop); !set) return set;
  if (Result<void> homed = AwaitHomed(stop); !homed) return homed;
  takes_moves = TakesMoves(stop);
  if (!takes_moves) return Fail(takes_moves.error());
  if (*takes_moves) return {};
  return Fail(ErrorCode::kDevice, "{}: stands and is not homed; every joint needs a HOME_SEQUENCE in its INI file",
              session_.Name());
}

Result<void> LinuxcncPositioner::SwitchOn(const std::stop_token& stop) {
  if (const Result<std::string> old = session_.Messages(stop); !old) return Fail(old.error());  // of what was before
  Result<RshState> state = session_.State(stop);
  if (!state) return Fail(state.error());
  if (!state->emergency_stop && !state->power) {
    if (Result<void> set = session_.Set("machine on", stop); !set) return set;
    for (const double end_s = clock_.NowS() + kPowerOn_s; !state->power && clock_.NowS() <= end_s;) {
      if (!clock_.Wait(kPoll_s, stop)) break;
      state = session_.State(stop);
      if (!state) return Fail(state.error());
    }
  }
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "{}: was stopped on request", session_.Name());
  if (Result<void> well = CheckWell(*state, stop); !well) return well;
  if (state->program == "IDLE") return {};
  return Fail(ErrorCode::kDevice, "{}: somebody else moves it", session_.Name());
}

Result<bool> LinuxcncPositioner::TakesMoves(const std::stop_token& stop) {
  if (Result<void> set = session_.Set("mode mdi", stop); !set) return Fail(set.error());
  if (Result<void> set = session_.Set("mdi G21 G90 G94", stop); !set) return Fail(set.error());  // moves nothing
  const Result<std::string> messages = session_.Messages(stop);
  if (!messages) return Fail(messages.error());
  if (messages->empty()) return true;
  if (messages->find(kNotHomed) != std::string::npos) return false;
  return Fail(ErrorCode::kDevice, "{}: {}", session_.Name(), *messages);
}

Result<void> LinuxcncPositioner::AwaitHomed(const std::stop_token& stop) {
  const double end_s = clock_.NowS() + settings_.move_timeout_s;
  double still_since_s = clock_.NowS();
  std::pair<std::string, std::string> before;
  while (clock_.NowS() - still_since_s < kHomeStill_s) {
    const Result<RshState> state = session_.State(stop);
    if (!state) return Fail(state.error());
    if (Result<void> well = CheckWell(*state, stop); !well) return well;
    const Result<std::string> homed = session_.Get("joint_homed", stop), at = session_.Get("joint_pos", stop);
    if (!homed) return Fail(homed.error());
    if (!at) return Fail(at.error());
    if (before != std::pair(*at, *homed)) still_since_s = clock_.NowS();
    before = {*at, *homed};
    if (clock_.NowS() > end_s) {
      return Fail(ErrorCode::kTimeout, "{}: homing did not end within {:.1f} s, joints homed: {}", session_.Name(),
                  settings_.move_timeout_s, *homed);
    }
    if (!clock_.Wait(kPoll_s, stop)) {
      return Fail(ErrorCode::kCancelled, "{}: homing was stopped on request", session_.Name());
    }
  }
  return {};
}

Result<std::string> LinuxcncPositioner::JointTrouble(const std::stop_token& stop) {
  std::vector<std::string> trouble;
  for (const char* what : {"joint_limit", "joint_fault"}) {
    const Result<std::string> words = session_.Get(what, stop);
    if (!words) return words;
    std::ranges::move(JointsNotOk(*words), std::back_inserter(trouble));
  }
  return Joined(trouble, ", ");
}

Result<void> LinuxcncPositioner::CheckWell(const RshState& state, const std::stop_token& stop) {
  Result<std::string> messages = session_.Messages(stop);
  if (!messages) return Fail(messages.error());
  std::string why;
  if (state.emergency_stop) {
    why = "the emergency stop is on; reset it at the machine (F1, or 'set estop off' of linuxcncrsh)";
  } else if (!state.power) {
    why = "its power is off";
  } else if (state.program == "PAUSED") {
    why = "somebody paused it";
  }
  if (why.empty() && messages->empty()) return {};
  const Result<std::string> joints = JointTrouble(stop);
  if (!joints) return Fail(joints.error());
  for (const std::string& part : {*messages, *joints}) {
    if (!part.empty()) why += (why.empty() ? "" : "; ") + part;
  }
  return Fail(ErrorCode::kDevice, "{}: {}", session_.Name(), why);
}

Result<RshPosition> LinuxcncPositioner::StandsReady(const std::stop_token& stop) {
  if (const Result<std::string> old = session_.Messages(stop); !old) return Fail(old.error());  // of what was before
  const Result<RshState> state = session_.State(stop);
  if (!state) return Fail(state.error());
  if (Result<void> well = CheckWell(*state, stop); !well) return Fail(well.error());
  if (state->program != "IDLE") return Fail(ErrorCode::kDevice, "{}: somebody else moves it", session_.Name());
  if (rested_) {
    Result<void> unmoved = CheckUnmoved(AxesAt(*rested_), AxesAt(state->at), settings_, session_.Name());
    if (!unmoved) return Fail(unmoved.error());
  }
  if (state->mode != "MDI") {
    if (Result<void> set = session_.Set("mode mdi", stop); !set) return Fail(set.error());
  }
  return state->at;
}

Result<RecordedStop> LinuxcncPositioner::MoveTo(const StopTarget& target, const std::stop_token& stop) {
  if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "{}: was stopped on request", session_.Name());
  if (Result<void> valid = CheckTarget(target, settings_.axes, session_.Name()); !valid) return Fail(valid.error());
  try {
    Result<RecordedStop> moved = MoveToRest(target, stop);
    if (!moved) return Stopped(moved.error());
    return moved;
  } catch (...) {
    Halt();
    throw;
  }
}

Result<RecordedStop> LinuxcncPositioner::MoveToRest(const StopTarget& target, const std::stop_token& stop) {
  const double end_s = clock_.NowS() + settings_.move_timeout_s;
  Result<RshPosition> at = StandsReady(stop);
  if (!at) return Fail(at.error());
  const StopTarget begin = BeginOfApproach(target, AxesAt(*at), settings_.axes, approached_);
  if (Result<void> valid = CheckTarget(begin, settings_.axes, session_.Name()); !valid) return Fail(valid.error());
  if (begin.axes != target.axes) at = Travel(begin.axes, *at, end_s, stop);
  if (at) at = Travel(target.axes, *at, end_s, stop);
  if (!at) {
    if (at.error().code != ErrorCode::kTimeout) return Fail(at.error());
    return Fail(ErrorCode::kTimeout, "{}, on the way to stop '{}'", at.error().message, target.id);
  }
  Result<RecordedStop> arrived = ArrivedAt(target, AxesAt(*at), settings_, session_.Name());
  if (!arrived) return arrived;
  rested_ = *at;
  approached_ = true;
  return arrived;
}

Result<RshPosition> LinuxcncPositioner::Travel(const std::vector<double>& target, const RshPosition& from, double end_s,
                                               const std::stop_token& stop) {
  if (Result<void> set = session_.Set("mdi " + MdiMove(from, target, settings_.axes), stop); !set) {
    return Fail(set.error());
  }
  std::optional<RshPosition> idle_at;
  while (true) {
    const Result<RshState> state = session_.State(stop);
    if (!state) return Fail(state.error());
    if (Result<void> well = CheckWell(*state, stop); !well) return Fail(well.error());
    // Idle twice at one place: a move that has not begun yet, or a drive that lags, is no rest.
    if (state->program == "IDLE" && idle_at == state->at) return state->at;
    idle_at.reset();
    if (state->program == "IDLE") idle_at = state->at;
    if (clock_.NowS() > end_s) {
      return Fail(ErrorCode::kTimeout, "{}: the move took more than {:.1f} s", session_.Name(),
                  settings_.move_timeout_s);
    }
    if (!clock_.Wait(kPoll_s, stop)) {
      return Fail(ErrorCode::kCancelled, "{}: the move was stopped on request", session_.Name());
    }
  }
}

Result<void> LinuxcncPositioner::FinishStop(const Result<void>& /*taken*/) {
  return {};
}

void LinuxcncPositioner::Halt() noexcept {
  rested_.reset();
  approached_ = false;
  (void)session_.Stop();
}

}  // namespace rigcal
