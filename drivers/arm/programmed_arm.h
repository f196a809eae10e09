#pragma once

#include <list>
#include <memory>
#include <set>
#include <string>

#include "core/base/clock.h"
#include "core/scene/rig_devices.h"
#include "drivers/arm/arm.h"
#include "drivers/arm/listener.h"

namespace rigcal {

/// An arm whose program connects by TCP and says where the arm is (README.md). The program is who sends the first line
/// that begins with "pose"; who says something else, or nothing, is not taken for it. A line of the program that is
/// refused is answered with the reason and ends the acquisition: no stop that it believes in is left out in silence.
class ProgrammedArm final : public Arm {
 public:
  /// Listens. `clock` outlives it. Errors: kDevice, those of Listener.
  static Result<std::unique_ptr<ProgrammedArm>> Listen(const SocketAddress& address, const PositionerSettings& settings,
                                                       Clock& clock);

  /// Where it listens, with the port that it got.
  [[nodiscard]] const SocketAddress& Address() const { return listener_.Address(); }

  /// The next pose that the program sends; nothing once it has sent "end", or closed the connection in good order after
  /// the answer to a pose.
  Result<std::optional<RecordedStop>> NextStop(const std::stop_token& stop) override;

  /// Answers "done K" or "error K TEXT". Errors: kDevice: the program has gone, or did not wait for the answer.
  Result<void> FinishStop(const Result<void>& taken) override;

  /// rigcal cannot stop it; a program that waits for the answer to a pose gets an error.
  void Halt() noexcept override;

 private:
  using Heard = std::optional<RecordedStop>;  ///< a pose, or nothing: the end

  ProgrammedArm(Listener listener, double timeout_s, Clock& clock)
      : listener_(std::move(listener)), timeout_s_(timeout_s), clock_(clock) {}

  /// Lets in who has connected, and finds the program among them.
  void Welcome();
  /// What those said who may be the program. The program is found: the line with its pose.
  void HearStrangers();
  /// What the program has said; nothing yet where it has not.
  std::optional<Result<Heard>> HearProgram();
  Result<Heard> Understand(const std::string& line);
  Result<Heard> Gone();
  /// Tells the program what is wrong with its line. Gives the Error that ends the acquisition.
  tl::unexpected<Error> Refuse(const std::string& name, const std::string& why);
  /// "after stop 'K'"
  [[nodiscard]] std::string AfterLast() const;

  Listener listener_;
  double timeout_s_;
  Clock& clock_;
  std::list<LineConnection> strangers_;  ///< connected, and have not said yet who they are
  std::optional<LineConnection> program_;
  std::optional<std::string> first_line_;  ///< by which the program was found, until it is understood
  std::set<std::string> named_;            ///< the stops that were
  std::string last_;                       ///< the latest of them
  bool unanswered_ = false;                ///< the program waits for the answer to `last_`
  bool ended_ = false;
};

}  // namespace rigcal
