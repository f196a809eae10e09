#include "drivers/grbl/grbl_positioner.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/joined.h"
#include "drivers/driver.h"
#include "drivers/grbl/jog_path.h"

namespace rigcal {
namespace {

constexpr double kPoll_s = 0.1;  ///< GRBL's own advice: at most 5 to 10 questions a second
constexpr double kSecondsPerMinute = 60;

/// Whatever ends a move leaves the machine stopped, unless it has got there.
class HaltUnlessThere {
 public:
  explicit HaltUnlessThere(PositionerDevice& device) : device_(&device) {}
  HaltUnlessThere(const HaltUnlessThere&) = delete;
  HaltUnlessThere& operator=(const HaltUnlessThere&) = delete;
  ~HaltUnlessThere() {
    if (device_ != nullptr) device_->Halt();
  }
  void IsThere() { device_ = nullptr; }

 private:
  PositionerDevice* device_;
};

/// The index into X, Y, Z of each axis.
Result<std::vector<int>> AxesOf(const PositionerSettings& settings) {
  std::vector<int> indices;
  for (const AxisSettings& axis : settings.axes) {
    const std::size_t index = kGrblAxisLetters.find(axis.device_letter);
    if (axis.device_letter.size() != 1 || index == std::string_view::npos) {
      return Fail(ErrorCode::kBadInput, "grbl: {}: the axis '{}' has the letter '{}', GRBL has X, Y and Z",
                  settings.address, axis.name, axis.device_letter);
    }
    if (std::ranges::count(indices, static_cast<int>(index)) > 0) {
      return Fail(ErrorCode::kBadInput, "grbl: {}: the axis '{}' has the letter {} of another one", settings.address,
                  axis.name, axis.device_letter);
    }
    indices.push_back(static_cast<int>(index));
  }
  if (indices.empty()) return Fail(ErrorCode::kBadInput, "grbl: {}: there is no axis to move", settings.address);
  return indices;
}

}  // namespace

Result<std::unique_ptr<PositionerDevice>> GrblPositioner::Open(const PositionerSettings& settings, Clock& clock,
                                                               const std::stop_token& stop) {
  Result<std::vector<int>> axes = AxesOf(settings);
  if (!axes) return Fail(axes.error());
  Result<GrblBoard> board = GrblBoard::Open(settings.address, clock, stop);
  if (!board) return Fail(board.error());
  return std::unique_ptr<PositionerDevice>(new GrblPositioner(std::move(*board), settings, std::move(*axes), clock));
}

GrblPositioner::GrblPositioner(GrblBoard board, const PositionerSettings& settings, std::vector<int> axes, Clock& clock)
    : board_(std::move(board)), settings_(settings), axes_(std::move(axes)), clock_(clock) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const AxisSettings& axis = settings_.axes[i];
    const double most_per_s = board_.Machine().max_rate_per_min[axes_[i]] / kSecondsPerMinute;
    speed_per_s_.push_back(axis.speed > 0 ? std::min(GrblFromAxis(axis.speed, axis.unit), most_per_s) : most_per_s);
  }
}

tl::unexpected<Error> GrblPositioner::WithAxes(const Error& error) {
  if (error.code == ErrorCode::kCancelled) return Fail(error);
  if (error.code == ErrorCode::kDevice) homed_ = false;  // an alarm or a reset: steps may be lost
  std::vector<std::string> names;
  for (const AxisSettings& axis : settings_.axes) names.push_back(fmt::format("'{}'", axis.name));
  return Fail(error.code, "{} (axis {}){}", error.message, Joined(names, ", "),
              error.code == ErrorCode::kDevice ? "; its position is not certain, home it" : "");
}

Result<void> GrblPositioner::Home(const std::stop_token& stop) {
  HaltUnlessThere guard(*this);
  if (Result<void> homed = HomeAtRest(stop); !homed) return WithAxes(homed.error());
  guard.IsThere();
  return {};
}

Result<void> GrblPositioner::HomeAtRest(const std::stop_token& stop) {
  if (homed_) return {};
  rested_.reset();
  approached_ = false;
  if (Result<void> reset = board_.Reset(stop); !reset) return reset;  // out of an alarm that waits for it
  GrblStatus status;
  if (const Result<GrblStatus> asked = board_.Status(stop)) {
    status = *asked;
  } else {
    return Fail(asked.error());
  }
  if (status.state != GrblState::kAlarm) {
    if (Result<void> rests = CheckIdle(status); !rests) return rests;
  }
  if (board_.Machine().homing) {
    if (Result<void> sent = board_.SendHoming(settings_.move_timeout_s, stop); !sent) return sent;
  } else if (status.state == GrblState::kAlarm) {
    if (Result<void> sent = board_.Send("$X", stop); !sent) return sent;
  }
  if (Result<void> sent = board_.Send("G54", stop); !sent) return sent;  // of which positions are told
  const Result<GrblPosition> at = board_.PositionInWork(status, stop);
  if (!at) return Fail(at.error());
  if (Result<void> rests = CheckIdle(status); !rests) return rests;
  homed_ = true;
  rested_ = *at;
  return {};
}

Result<void> GrblPositioner::CheckMoving(const GrblStatus& status) const {
  const char* why = nullptr;
  switch (status.state) {
    case GrblState::kIdle:
    case GrblState::kRun:
    case GrblState::kJog:
      return {};
    case GrblState::kDoor:
      why = "the safety door is open";
      break;
    case GrblState::kHold:
      why = "somebody held it (feed hold)";
      break;
    case GrblState::kAlarm:
      why = "it is locked by an alarm";
      break;
    case GrblState::kCheck:
    case GrblState::kHome:
    case GrblState::kSleep:
      why = "it takes no moves";
      break;
  }
  return Fail(ErrorCode::kDevice, "grbl: {}: state {}: {}{}{}", board_.Path(), NameOf(status.state), why,
              status.pins.empty() ? "" : ", inputs that are on: ", status.pins);
}

tl::unexpected<Error> GrblPositioner::WhyRefused(const Error& answered, const std::stop_token& stop) {
  if (!board_.Refused()) return Fail(answered);
  const Result<GrblStatus> status = board_.Status(stop);
  const Result<void> moving = status ? CheckMoving(*status) : Result<void>();
  return Fail(moving ? answered : moving.error());
}

Result<void> GrblPositioner::CheckIdle(const GrblStatus& status) const {
  if (Result<void> well = CheckMoving(status); !well || status.state == GrblState::kIdle) return well;
  return Fail(ErrorCode::kDevice, "grbl: {}: state {}: somebody else moves it, or a startup block ($N0, $N1)",
              board_.Path(), NameOf(status.state));
}

Result<GrblPosition> GrblPositioner::StandsReady(const std::stop_token& stop) {
  GrblStatus status;
  Result<GrblPosition> at = board_.PositionInWork(status, stop);
  if (!at) return at;
  if (Result<void> rests = CheckIdle(status); !rests) return Fail(rests.error());
  if (!homed_) return Fail(ErrorCode::kDevice, "grbl: {}: it is not homed", board_.Path());
  if (!rested_) return at;
  const std::string device = fmt::format("grbl: {}", board_.Path());
  if (Result<void> unmoved = CheckUnmoved(AxesAt(*rested_), AxesAt(*at), settings_, device); !unmoved) {
    return Fail(unmoved.error());
  }
  return at;
}

std::vector<double> GrblPositioner::AxesAt(const GrblPosition& at) const {
  std::vector<double> axes;
  for (std::size_t i = 0; i < axes_.size(); ++i) axes.push_back(AxisFromGrbl(at[axes_[i]], settings_.axes[i].unit));
  return axes;
}

Result<RecordedStop> GrblPositioner::MoveTo(const StopTarget& target, const std::stop_token& stop) {
  if (stop.stop_requested()) {
    return Fail(ErrorCode::kCancelled, "grbl: {}: was stopped on request", board_.Path());
  }
  const std::string device = fmt::format("grbl: {}", board_.Path());
  if (Result<void> valid = CheckTarget(target, settings_.axes, device); !valid) return Fail(valid.error());
  HaltUnlessThere guard(*this);
  const double end_s = clock_.NowS() + settings_.move_timeout_s;
  Result<GrblPosition> at = StandsReady(stop);
  if (!at) return WithAxes(at.error());
  const StopTarget begin = BeginOfApproach(target, AxesAt(*at), settings_.axes, approached_);
  if (Result<void> valid = CheckTarget(begin, settings_.axes, device); !valid) return Fail(valid.error());
  if (begin.axes != target.axes) at = Travel(begin, *at, end_s, stop);
  if (at) at = Travel(target, *at, end_s, stop);
  if (!at) return WithAxes(at.error());
  Result<RecordedStop> arrived = ArrivedAt(target, AxesAt(*at), settings_, device);
  if (!arrived) return arrived;
  guard.IsThere();
  rested_ = *at;
  approached_ = true;
  return arrived;
}

Result<GrblPosition> GrblPositioner::Travel(const StopTarget& target, const GrblPosition& from, double end_s,
                                            const std::stop_token& stop) {
  GrblPosition to = from;
  for (std::size_t i = 0; i < axes_.size(); ++i) to[axes_[i]] = GrblFromAxis(target.axes[i], settings_.axes[i].unit);
  JogPath path(from, to, axes_, speed_per_s_, board_.Machine());
  GrblPosition at = from;
  while (true) {
    for (std::string jog = path.NextJog(at); !jog.empty(); jog = path.NextJog(at)) {
      if (Result<void> sent = board_.Send(jog, stop); !sent) return WhyRefused(sent.error(), stop);
    }
    const bool all_sent = path.AllSent();
    GrblStatus status;
    const Result<GrblPosition> now_at = board_.PositionInWork(status, stop);
    if (!now_at) return now_at;
    at = *now_at;
    if (Result<void> well = CheckMoving(status); !well) return Fail(well.error());
    if (all_sent && status.state == GrblState::kIdle) return at;
    if (clock_.NowS() > end_s) {
      return Fail(ErrorCode::kTimeout, "grbl: {}: stop '{}' was not reached within {:.1f} s", board_.Path(), target.id,
                  settings_.move_timeout_s);
    }
    if (!clock_.Wait(kPoll_s, stop)) {
      return Fail(ErrorCode::kCancelled, "grbl: {}: the move was stopped on request", board_.Path());
    }
  }
}

Result<void> GrblPositioner::FinishStop(const Result<void>& /*taken*/) {
  return {};
}

void GrblPositioner::Halt() noexcept {
  rested_.reset();
  approached_ = false;
  if (!board_.Stop()) homed_ = false;
}

}  // namespace rigcal
