#include "drivers/grbl/grbl_board.h"

#include <charconv>
#include <utility>

namespace rigcal {
namespace {

constexpr char kHold = '!', kAsk = '?', kReset = '\x18';
constexpr double kAskAgain_s = 1;         ///< a reset that fell into the boot loader is sent again
constexpr double kHomingPause_s = 0.1;    ///< homing takes seconds, and GRBL says nothing meanwhile
constexpr int kMostReportsToOffset = 31;  ///< GRBL 1.1 reports its offset at least every 30th time
constexpr std::string_view kAxisWords = "XYZABCxyzabc";
constexpr int kInches = 13, kHoming = 22, kMaxRate = 110, kMaxAcceleration = 120;  ///< numbers of its settings

std::string One(char c) {
  return {c};
}

double ValueOf(const std::string& text) {
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

bool IsOld(const std::string& version) {
  return ValueOf(version) < 1.1;
}

}  // namespace

tl::unexpected<Error> GrblBoard::NoAnswer(std::string_view to, double timeout_s) const {
  return Fail(ErrorCode::kTimeout, "grbl: {}: no answer to '{}' within {} s", Path(), to, timeout_s);
}

tl::unexpected<Error> GrblBoard::Stopped() const {
  return Fail(ErrorCode::kCancelled, "grbl: {}: was stopped on request", Path());
}

Result<GrblBoard> GrblBoard::Open(const std::string& path, Clock& clock, const std::stop_token& stop) {
  Result<SerialLine> line = SerialLine::Open(path);
  if (!line) return Fail(line.error());
  GrblBoard board(std::move(*line), clock);
  if (Result<void> reset = board.Reset(stop); !reset) {
    if (reset.error().code != ErrorCode::kTimeout) return Fail(reset.error());
    return Fail(ErrorCode::kDevice, "grbl: {}: nothing that speaks GRBL answers at 115200 baud within {} s", path,
                kOpen_s);
  }
  if (IsOld(board.machine_.version)) {
    return Fail(ErrorCode::kUnsupported, "grbl: {}: the controller is GRBL {}, rigcal needs 1.1 or later", path,
                board.machine_.version);
  }
  if (Result<void> read = board.ReadMachine(stop); !read) return Fail(read.error());
  return board;
}

Result<void> GrblBoard::ReadMachine(const std::stop_token& stop) {
  const Result<GrblStatus> status = Status(stop);
  if (!status) return Fail(status.error());
  if (status->state != GrblState::kIdle && status->state != GrblState::kAlarm) {
    return Fail(ErrorCode::kDevice, "grbl: {}: the controller is in the state {} and takes no commands{}", Path(),
                NameOf(status->state), status->state == GrblState::kDoor ? ": the safety door is open" : "");
  }
  bool inches = false;
  const Result<void> sent = Send("$$", stop, [&](const GrblLine& line) {
    if (line.kind != GrblLineKind::kSetting) return;
    const double value = ValueOf(line.text);
    if (line.number == kInches) inches = value != 0;
    if (line.number == kHoming) machine_.homing = value != 0;
    for (int axis = 0; axis < kNumGrblAxes; ++axis) {
      if (line.number == kMaxRate + axis) machine_.max_rate_per_min[axis] = value;
      if (line.number == kMaxAcceleration + axis) machine_.max_acceleration_per_s2[axis] = value;
    }
  });
  if (!sent) return sent;
  if (inches) return Fail(ErrorCode::kUnsupported, "grbl: {}: reports inches, set $13=0", Path());
  for (int axis = 0; axis < kNumGrblAxes; ++axis) {
    if (machine_.max_rate_per_min[axis] > 0 && machine_.max_acceleration_per_s2[axis] > 0) continue;
    return Fail(ErrorCode::kDevice, "grbl: {}: the controller does not say the greatest rate and acceleration of {}",
                Path(), kGrblAxisLetters[axis]);
  }
  return CheckStartupBlocks(stop);
}

Result<void> GrblBoard::CheckStartupBlocks(const std::stop_token& stop) {
  std::string moving;
  const Result<void> sent = Send("$N", stop, [&](const GrblLine& line) {
    const std::size_t equals = line.text.find('=');
    const bool block = line.text.starts_with("$N") && equals != std::string::npos;
    if (block && line.text.find_first_of(kAxisWords, equals) != std::string::npos) moving = line.text;
  });
  if (!moving.empty()) {
    return Fail(ErrorCode::kUnsupported, "grbl: {}: the startup block {} moves the machine after every reset, empty it",
                Path(), moving);
  }
  // A relative of GRBL may know no startup blocks.
  return sent || sent.error().code == ErrorCode::kDevice ? Result<void>() : sent;
}

Result<std::optional<GrblLine>> GrblBoard::Next() {
  const Result<std::optional<std::string>> text = line_.ReadLine();
  if (!text) return Fail(text.error());
  if (!*text) return std::nullopt;
  GrblLine line = ParseGrblLine(**text);
  if (line.kind == GrblLineKind::kAlarm) {
    return Fail(ErrorCode::kDevice, "grbl: {}: ALARM:{}, {}", Path(), line.number, GrblAlarmMeaning(line.number));
  }
  if (line.kind == GrblLineKind::kBanner) {
    work_in_machine_.reset();
    return Fail(ErrorCode::kDevice, "grbl: {}: the controller was reset", Path());
  }
  if (line.kind == GrblLineKind::kStatus && line.status.work_in_machine) work_in_machine_ = line.status.work_in_machine;
  return line;
}

Result<void> GrblBoard::AwaitOk(std::string_view command, double timeout_s, double pause_s, const std::stop_token& stop,
                                const std::function<void(const GrblLine&)>& each_line) {
  const double end_s = clock_.NowS() + timeout_s;
  refused_ = false;
  while (true) {
    if (stop.stop_requested()) return Stopped();
    const Result<std::optional<GrblLine>> line = Next();
    if (!line) return Fail(line.error());
    if (*line && (*line)->kind == GrblLineKind::kOk) return {};
    if (*line && (*line)->kind == GrblLineKind::kError) {
      refused_ = true;
      return Fail(ErrorCode::kDevice, "grbl: {}: '{}' was answered by error:{}, {}", Path(), command, (*line)->number,
                  GrblErrorMeaning((*line)->number));
    }
    if (*line && each_line) each_line(**line);
    if (clock_.NowS() > end_s) return NoAnswer(command, timeout_s);
    if (pause_s > 0 && !clock_.Wait(pause_s, stop)) return Stopped();
  }
}

Result<void> GrblBoard::Send(std::string_view command, const std::stop_token& stop,
                             const std::function<void(const GrblLine&)>& each_line) {
  if (Result<void> sent = line_.Write(std::string(command) + '\n'); !sent) return sent;
  return AwaitOk(command, kAnswer_s, 0, stop, each_line);
}

Result<void> GrblBoard::SendHoming(double timeout_s, const std::stop_token& stop) {
  if (Result<void> sent = line_.Write("$H\n"); !sent) return sent;
  return AwaitOk("$H", timeout_s, kHomingPause_s, stop, {});
}

Result<GrblStatus> GrblBoard::Status(const std::stop_token& stop) {
  for (int ask = 0; ask < kMostAsks; ++ask) {
    if (Result<void> sent = line_.Write(One(kAsk)); !sent) return Fail(sent.error());
    const double end_s = clock_.NowS() + kAnswer_s;
    do {
      if (stop.stop_requested()) return Stopped();
      Result<std::optional<GrblLine>> line = Next();
      if (!line) return Fail(line.error());
      if (*line && (*line)->kind == GrblLineKind::kStatus) return std::move((*line)->status);
    } while (clock_.NowS() <= end_s);
  }
  return NoAnswer("?", kMostAsks * kAnswer_s);
}

Result<GrblPosition> GrblBoard::PositionInWork(GrblStatus& status, const std::stop_token& stop) {
  for (int report = 0; report <= kMostReportsToOffset; ++report) {
    Result<GrblStatus> asked = Status(stop);
    if (!asked) return Fail(asked.error());
    status = std::move(*asked);
    if (status.in_work) return *status.in_work;
    if (!work_in_machine_) continue;
    GrblPosition in_work = *status.in_machine;
    for (int axis = 0; axis < kNumGrblAxes; ++axis) in_work[axis] -= (*work_in_machine_)[axis];
    return in_work;
  }
  return Fail(ErrorCode::kUnsupported, "grbl: {}: reports positions of the machine without the work offset, set $10=0",
              Path());
}

Result<void> GrblBoard::Reset(const std::stop_token& stop) {
  const double begin_s = clock_.NowS();
  double next_s = begin_s;
  while (clock_.NowS() - begin_s <= kOpen_s) {
    if (stop.stop_requested()) return Stopped();
    if (clock_.NowS() >= next_s) {
      if (Result<void> sent = line_.Write(One(kReset)); !sent) return sent;
      next_s = clock_.NowS() + kAskAgain_s;
    }
    const Result<std::optional<std::string>> text = line_.ReadLine();
    if (!text) return Fail(text.error());
    if (!*text) continue;
    const GrblLine line = ParseGrblLine(**text);
    if (line.kind != GrblLineKind::kBanner) continue;
    machine_.version = line.text;
    work_in_machine_.reset();
    return TakeRestOfReset();
  }
  return NoAnswer("reset", kOpen_s);
}

Result<void> GrblBoard::TakeRestOfReset() {
  for (int i = 0; i < kMostLinesAfterReset; ++i) {
    const Result<std::optional<std::string>> text = line_.ReadLine();
    if (!text) return Fail(text.error());
    if (!*text) return {};
  }
  return Fail(ErrorCode::kDevice, "grbl: {}: does not cease to send after its reset", Path());
}

bool GrblBoard::HoldAndReset() {
  SystemClock real;  // a machine's stop has to come in real time, whatever clock the rest goes by
  bool stood = false;
  if (!line_.Write(One(kHold))) return false;
  for (const double end_s = real.NowS() + kStandstill_s; !stood && real.NowS() < end_s;) {
    if (!line_.Write(One(kAsk))) return false;
    const Result<std::optional<std::string>> text = line_.ReadLine();
    if (!text) return false;
    if (!*text) continue;
    const GrblLine line = ParseGrblLine(**text);
    if (line.kind == GrblLineKind::kAlarm) break;
    if (line.kind != GrblLineKind::kStatus || !line.status.AtRest()) continue;
    if (line.status.state == GrblState::kAlarm) break;
    stood = true;
  }
  if (!line_.Write(One(kReset))) return false;
  work_in_machine_.reset();
  for (const double end_s = real.NowS() + kReset_s; real.NowS() < end_s;) {
    const Result<std::optional<std::string>> text = line_.ReadLine();
    if (!text) return false;
    if (!*text) continue;
    const GrblLine line = ParseGrblLine(**text);
    if (line.kind == GrblLineKind::kAlarm) stood = false;
    if (line.kind == GrblLineKind::kBanner) return stood;
  }
  return false;
}

bool GrblBoard::Stop() noexcept {
  try {
    return HoldAndReset();
  } catch (...) {  // out of memory: nothing is known then
    return false;
  }
}

}  // namespace rigcal
