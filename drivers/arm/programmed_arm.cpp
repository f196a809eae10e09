#include "drivers/arm/programmed_arm.h"

#include <utility>

#include "drivers/arm/pose_line.h"

namespace rigcal {
namespace {

constexpr double kPoll_s = 0.02;           ///< how often connections are looked at; far below what a stop takes
constexpr std::size_t kMostStrangers = 8;  ///< at once; the first of more has to go
constexpr std::size_t kMostQuoted = 60;    ///< bytes of a foreign line in a message
constexpr std::string_view kPose = "pose", kEnd = "end";
constexpr const char* kAnother = "error - another program moves the arm already, this connection is closed";

/// The first word of a line, and what follows it.
std::pair<std::string_view, std::string_view> Split(std::string_view line) {
  constexpr std::string_view kBlank = " \t";
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::size_t end = std::min(line.find_first_of(kBlank), line.size());
  return {line.substr(0, end), line.substr(end)};
}

std::string NotUnderstood(std::string_view line) {
  if (line.size() > kLongestLine_bytes) return fmt::format("a line has at most {} bytes", kLongestLine_bytes);
  return fmt::format("'{}' is neither 'pose K x y z qw qx qy qz' nor 'end'",
                     OnOneLine(std::string(line.substr(0, kMostQuoted))));
}

}  // namespace

Result<std::unique_ptr<ProgrammedArm>> ProgrammedArm::Listen(const SocketAddress& address,
                                                             const PositionerSettings& settings, Clock& clock) {
  Result<Listener> listener = Listener::Open(address);
  if (!listener) return Fail(listener.error());
  return std::unique_ptr<ProgrammedArm>(new ProgrammedArm(std::move(*listener), settings.move_timeout_s, clock));
}

Result<std::optional<RecordedStop>> ProgrammedArm::NextStop(const std::stop_token& stop) {
  const double end_s = clock_.NowS() + timeout_s_;
  while (!stop.stop_requested()) {
    if (ended_) return Heard();
    Welcome();
    if (program_) {
      if (std::optional<Result<Heard>> heard = HearProgram()) return std::move(*heard);
    }
    if (clock_.NowS() >= end_s) {
      const std::string limit = fmt::format("within {:.1f} s", timeout_s_);
      if (program_) program_->Send(fmt::format("error - no pose {}", limit));
      return Fail(ErrorCode::kTimeout, "arm: no {} {} {}", program_ ? "pose" : "program has sent a pose",
                  program_ ? AfterLast() : "to " + ToText(Address()), limit);
    }
    clock_.Wait(kPoll_s, stop);
  }
  if (program_) program_->Send("error - the capture was stopped on request");
  return Fail(ErrorCode::kCancelled, "arm: waiting for its next pose was stopped on request");
}

void ProgrammedArm::Welcome() {
  for (std::size_t i = 0; i < kMostStrangers; ++i) {  // more at once wait for the next look
    std::optional<LineConnection> newcomer = listener_.Accept();
    if (!newcomer) break;
    if (strangers_.size() == kMostStrangers) strangers_.pop_front();
    strangers_.push_back(std::move(*newcomer));
  }
  if (!program_) HearStrangers();
  if (!program_) return;
  for (LineConnection& stranger : strangers_) stranger.Send(kAnother);
  strangers_.clear();
}

void ProgrammedArm::HearStrangers() {
  for (auto stranger = strangers_.begin(); stranger != strangers_.end() && !program_;) {
    stranger->Receive();
    const std::optional<std::string> line = stranger->TakeLine();
    if (line && Split(*line).first == kPose) {
      program_ = std::move(*stranger);
      first_line_ = line;
    } else if (line) {
      stranger->Send("error - " + (*line == kEnd ? "'end' came before the first pose" : NotUnderstood(*line)));
    }
    const bool stays = !line && !stranger->Closed() && !stranger->Lost();
    stranger = stays ? std::next(stranger) : strangers_.erase(stranger);
  }
}

std::optional<Result<ProgrammedArm::Heard>> ProgrammedArm::HearProgram() {
  if (first_line_) return Understand(*std::exchange(first_line_, std::nullopt));
  program_->Receive();
  std::optional<std::string> line = program_->TakeLine();
  if (line) return Understand(*line);
  if (program_->Closed() || program_->Lost()) return Gone();
  return std::nullopt;
}

Result<ProgrammedArm::Heard> ProgrammedArm::Understand(const std::string& line) {
  const auto [word, rest] = Split(line);
  if (line.size() > kLongestLine_bytes || (word != kPose && word != kEnd)) return Refuse("-", NotUnderstood(line));
  if (word == kEnd) {
    ended_ = true;
    return Heard();
  }
  Result<RecordedStop> stop = ParsePose(rest);
  if (!stop) return Refuse(StopNamed(rest), stop.error().message);
  if (named_.contains(stop->id)) return Refuse(stop->id, fmt::format("the stop '{}' was there already", stop->id));
  program_->Receive();
  if (Split(program_->Begun()).first == kPose) {
    return Refuse(stop->id,
                  fmt::format("the next pose came before the answer to '{}': the arm may be moving", stop->id));
  }
  last_ = stop->id;
  named_.insert(last_);
  unanswered_ = true;
  return Heard(std::move(*stop));
}

Result<ProgrammedArm::Heard> ProgrammedArm::Gone() {
  const bool whole = !program_->Lost() && (program_->Begun().empty() || program_->Begun() == kEnd);
  if (whole) {
    ended_ = true;
    return Heard();
  }
  return Fail(ErrorCode::kDevice, "arm: the connection to its program at {} is lost {}{}", program_->Peer(),
              AfterLast(), program_->Lost() ? "" : ", in the middle of a line");
}

tl::unexpected<Error> ProgrammedArm::Refuse(const std::string& name, const std::string& why) {
  program_->Send(fmt::format("error {} {}", name, why));
  return Fail(ErrorCode::kDevice, "arm: its program at {} was refused {}: {}", program_->Peer(), AfterLast(), why);
}

std::string ProgrammedArm::AfterLast() const {
  return last_.empty() ? "at its first stop" : fmt::format("after stop '{}'", last_);
}

Result<void> ProgrammedArm::FinishStop(const Result<void>& taken) {
  if (!std::exchange(unanswered_, false)) return {};
  if (!taken) {
    program_->Send(fmt::format("error {} {}", last_, taken.error().message));
    return {};
  }
  program_->Receive();
  const std::string_view begun = program_->Begun();
  if (Split(begun).first == kPose) {
    const std::string why = fmt::format(
        "the next pose came before the answer to '{}': the arm may have moved while its pictures were taken; the "
        "recording must be taken anew",
        last_);
    return Refuse(last_, why);
  }
  const bool gone = program_->Lost() || (program_->Closed() && begun != kEnd);
  if (!gone && program_->Send("done " + last_)) return {};
  return Fail(ErrorCode::kDevice, "arm: its program at {} went away before the answer to stop '{}'", program_->Peer(),
              last_);
}

void ProgrammedArm::Halt() noexcept {
  try {
    if (std::exchange(unanswered_, false)) {
      program_->Send(fmt::format("error {} the capture ended before its pictures were taken", last_));
    }
  } catch (...) {  // no memory for the message: the connection is closed without it
  }
}

}  // namespace rigcal
