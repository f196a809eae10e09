#include "drivers/linuxcnc/rsh_session.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "core/base/joined.h"
#include "drivers/connect_to.h"

namespace rigcal {
namespace {

constexpr int kSlice_ms = 20;     ///< between two looks at the clock and the stop token
constexpr double kLook_s = 0.02;  ///< between two looks at a machine that is to stand
// How long it has to stand: after an abort that was obeyed, and in an emergency stop, when what it tells is up to 0.2 s
// old (seen with LinuxCNC 2.9).
constexpr double kStands_s = 0.02, kStandsInEmergency_s = 0.25;
constexpr int kMostReconnects = 1;  ///< while it is to stop: more find no time
// The passwords that linuxcncrsh has unless it is started with others.
constexpr std::string_view kHello = "hello EMC rigcal 1.0", kEnable = "set enable EMCTOO";
constexpr std::string_view kNoEcho = "set echo off", kAcknowledge = "set verbose on";
constexpr double kMmPerInch = 25.4, kMmPerCm = 10;

std::string UpperFirstWord(std::string_view text) {
  std::string word(text.substr(0, text.find(' ')));
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return word;
}

std::optional<RshPosition> PositionOf(std::string_view text) {
  RshPosition position{};
  for (double& value : position) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return position;
}

}  // namespace

RshSession::RshSession(SocketAddress address, RshRole role, Clock& clock)
    : address_(std::move(address)), role_(role), clock_(&clock), name_("linuxcnc: " + ToText(address_)) {}

tl::unexpected<Error> RshSession::Lost() {
  line_.reset();
  return Fail(ErrorCode::kDevice, "{}: the connection is lost", name_);
}

Result<RshSession> RshSession::Open(const SocketAddress& address, RshRole role, Clock& clock,
                                    const std::stop_token& stop) {
  RshSession session(address, role, clock);
  if (Result<void> restored = session.Restore(stop); !restored) return Fail(restored.error());
  return session;
}

Result<void> RshSession::Restore(const std::stop_token& stop) {
  if (line_) return {};
  Result<LineConnection> line = ConnectTo(address_, kConnect_s, *clock_, stop);
  if (!line) return Fail(line.error().code, "{}: {}", name_, line.error().message);
  line_ = std::move(*line);
  if (Result<void> greeted = SayHello(stop); !greeted) {
    line_.reset();
    if (greeted.error().code != ErrorCode::kTimeout) return greeted;
    return Fail(ErrorCode::kDevice, "{}: nothing that speaks as linuxcncrsh answers within {} s", name_, kAnswer_s);
  }
  return {};
}

Result<void> RshSession::SayHello(const std::stop_token& stop) {
  const Result<std::string> hello = Ask(kHello, {"HELLO ACK ", "HELLO NAK"}, *clock_, kAnswer_s, stop);
  if (!hello) return Fail(hello.error());
  if (hello->starts_with("HELLO NAK")) {
    return Fail(ErrorCode::kDevice, "{}: refuses the password that linuxcncrsh has by default (--connectpw)", name_);
  }
  server_ = hello->substr(std::string_view("HELLO ACK ").size());
  if (Result<void> sent = Send(kNoEcho); !sent) return sent;
  if (Result<void> sent = Set(kAcknowledge.substr(4), stop); !sent) return sent;
  if (role_ == RshRole::kControl) {
    const Result<std::string> enabled = Ask(kEnable, {"SET ENABLE ", ""}, *clock_, kAnswer_s, stop);
    if (!enabled) return Fail(enabled.error());
    if (!enabled->ends_with("ACK")) {
      return Fail(ErrorCode::kDevice, "{}: refuses the password that linuxcncrsh has by default (--enablepw)", name_);
    }
  }
  const Result<std::string> unit = Get("user_linear_units", stop);
  if (!unit) return Fail(unit.error());
  if (*unit != "MM" && *unit != "INCH" && *unit != "CM") {
    return Fail(ErrorCode::kUnsupported, "{}: LINEAR_UNITS of its INI file must be mm, cm or inch, it says {}", name_,
                *unit);
  }
  mm_per_unit_ = *unit == "MM" ? 1 : *unit == "CM" ? kMmPerCm : kMmPerInch;
  const Result<std::string> angle = Get("user_angular_units", stop);
  if (!angle) return Fail(angle.error());
  if (*angle == "DEG") return {};
  return Fail(ErrorCode::kUnsupported, "{}: ANGULAR_UNITS of its INI file must be degree, it says {}", name_, *angle);
}

Result<void> RshSession::Send(std::string_view request) {
  if (!line_ || !line_->Send(std::string(request))) return Lost();
  return {};
}

Result<std::string> RshSession::Ask(std::string_view request, const Begins& begins, Clock& clock, double timeout_s,
                                    const std::stop_token& stop) {
  const double end_s = clock.NowS() + timeout_s;
  if (Result<void> sent = Send(request); !sent) return Fail(sent.error());
  while (true) {
    if (!line_) return Lost();
    line_->Receive();
    while (std::optional<std::string> line = line_->TakeLine()) {
      for (const std::string_view begin : {begins.one, begins.other}) {
        if (!begin.empty() && line->starts_with(begin)) return std::move(*line);
      }
    }
    if (line_->Closed() || line_->Lost()) return Lost();
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "{}: was stopped on request", name_);
    if (clock.NowS() > end_s) {
      line_.reset();
      return Fail(ErrorCode::kTimeout, "{}: no answer to '{}' within {} s", name_, request, timeout_s);
    }
    line_->Await(kSlice_ms);
  }
}

Result<std::string> RshSession::Get(std::string_view what, const std::stop_token& stop) {
  return GetBy(*clock_, kAnswer_s, what, stop);
}

Result<std::string> RshSession::GetBy(Clock& clock, double timeout_s, std::string_view what,
                                      const std::stop_token& stop) {
  const std::string word = UpperFirstWord(what), told = word + ' ', refused = fmt::format("GET {} NAK", word);
  Result<std::string> line = Ask("get " + std::string(what), {told, refused}, clock, timeout_s, stop);
  if (!line) return line;
  if (line->starts_with(refused)) return Fail(ErrorCode::kUnsupported, "{}: does not tell '{}'", name_, what);
  return line->substr(word.size() + 1);
}

Result<void> RshSession::Set(std::string_view command, const std::stop_token& stop) {
  const std::string begin = fmt::format("SET {} ", UpperFirstWord(command));
  const Result<std::string> line = Ask("set " + std::string(command), {begin, ""}, *clock_, kAnswer_s, stop);
  if (!line) return Fail(line.error());
  if (line->ends_with("ACK")) return {};
  const Result<std::string> enabled = Get("enable", stop);
  if (!enabled) return Fail(enabled.error());
  return Fail(ErrorCode::kDevice, "{}: refuses 'set {}'{}", name_, command,
              *enabled == "ON" ? "" : ": another program has taken control of it");
}

Result<RshPosition> RshSession::Position(const std::stop_token& stop) {
  const Result<std::string> text = Get("abs_act_pos", stop);
  if (!text) return Fail(text.error());
  std::optional<RshPosition> position = PositionOf(*text);
  if (!position) return Fail(ErrorCode::kDevice, "{}: '{}' is no position", name_, *text);
  for (const char linear : std::string_view("XYZ")) (*position)[kRshAxisLetters.find(linear)] *= mm_per_unit_;
  return *position;
}

Result<RshState> RshSession::State(const std::stop_token& stop) {
  RshState state;
  const auto read = [&](std::string_view what, std::string& value) -> Result<void> {
    Result<std::string> got = Get(what, stop);
    if (!got) return Fail(got.error());
    value = std::move(*got);
    return {};
  };
  std::string emergency_stop, power;
  if (Result<void> got = read("estop", emergency_stop); !got) return Fail(got.error());
  if (Result<void> got = read("machine", power); !got) return Fail(got.error());
  if (Result<void> got = read("mode", state.mode); !got) return Fail(got.error());
  // The position comes last: where the program is said to be idle, the position is that after it.
  if (Result<void> got = read("program_status", state.program); !got) return Fail(got.error());
  const Result<RshPosition> at = Position(stop);
  if (!at) return Fail(at.error());
  state.emergency_stop = emergency_stop != "OFF";
  state.power = power == "ON";
  state.at = *at;
  return state;
}

Result<std::string> RshSession::Messages(const std::stop_token& stop) {
  std::vector<std::string> messages;
  for (int i = 0; i < kMostMessages; ++i) {
    Result<std::string> message = Get("error", stop);
    if (!message) return message;
    if (*message == "OK") break;
    messages.push_back(OnOneLine(std::move(*message)));
  }
  return Joined(messages, "; ");
}

bool RshSession::AbortAndStand() {
  SystemClock real;  // a machine's stop has to come in real time, whatever clock the rest goes by
  const double end_s = real.NowS() + kStop_s;
  const auto left_s = [&] { return std::max(0.0, end_s - real.NowS()); };
  std::optional<std::string> answer;
  for (int connects = 0; !answer; ++connects) {
    if (!line_) {
      if (connects > kMostReconnects) return false;
      Result<LineConnection> line = ConnectTo(address_, left_s(), real, {});
      if (!line) return false;
      line_ = std::move(*line);
      for (const std::string_view greeting : {kHello, kNoEcho, kAcknowledge}) (void)Send(greeting);
    }
    // All at once: the abort gets there even when no time is left to hear of it.
    if (!Send(kEnable)) continue;
    const Result<std::string> answered = Ask("set abort", {"SET ABORT ", ""}, real, left_s(), {});
    if (!answered && answered.error().code == ErrorCode::kTimeout) return false;
    if (answered) answer = *answered;
  }
  const double stands_s = answer->ends_with("ACK") ? kStands_s : kStandsInEmergency_s;
  // Joints, because homing moves them while the axes and the program may say nothing.
  std::string before;
  for (double since_s = real.NowS(); left_s() > 0; real.Wait(kLook_s, {})) {
    const Result<std::string> at = GetBy(real, left_s(), "joint_pos", {});
    const Result<std::string> program = GetBy(real, left_s(), "program_status", {});
    if (!at || !program) return false;
    if (*program != "IDLE" || before != *at) since_s = real.NowS();
    before = *at;
    if (real.NowS() - since_s >= stands_s) return true;
  }
  return false;
}

bool RshSession::Stop() noexcept {
  try {
    return AbortAndStand();
  } catch (...) {  // out of memory: nothing is known then
    return false;
  }
}

}  // namespace rigcal
