#pragma once

#include <array>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/base/clock.h"
#include "drivers/grbl/serial_line.h"

namespace rigcal {

/// What the controller says of itself (its banner and $$).
struct GrblMachine {
  std::string version;                     ///< "1.1h"
  bool homing = false;                     ///< $22: it has limit switches to home by
  GrblPosition max_rate_per_min{};         ///< $110 .. $112, controller units
  GrblPosition max_acceleration_per_s2{};  ///< $120 .. $122
};

/// The conversation with one GRBL 1.1 controller. Every Error names the serial device. Codes beside those of each
/// function: kDevice (alarm, error, reset in the middle, line gone), kTimeout (no answer), kCancelled.
class GrblBoard {
 public:
  static constexpr double kOpen_s = 8;    ///< a board that resets when it is opened is in its boot loader for 2 s
  static constexpr double kAnswer_s = 2;  ///< GRBL answers '?' within 20 ms, a command that moves nothing within 100
  static constexpr int kMostAsks = 3;     ///< of '?' for one report: some are lost, so is one in the middle of a reset
  static constexpr int kMostLinesAfterReset = 100;              ///< GRBL sends five at most
  static constexpr double kStandstill_s = 0.4, kReset_s = 0.4;  ///< of Stop: below its one second together

  /// Opens the line, resets the controller (nothing moves then, whoever had moved it) and reads its settings. Errors:
  /// those of SerialLine::Open; kDevice (nothing that speaks GRBL); kUnsupported (older than 1.1, it reports
  /// inches, or a startup block moves it).
  static Result<GrblBoard> Open(const std::string& path, Clock& clock, const std::stop_token& stop);

  [[nodiscard]] const GrblMachine& Machine() const { return machine_; }
  [[nodiscard]] const std::string& Path() const { return line_.Path(); }

  /// Sends a line and waits for its ok; `each_line` sees what comes before it and may be empty. Errors also: the
  /// controller's own, in words.
  Result<void> Send(std::string_view command, const std::stop_token& stop,
                    const std::function<void(const GrblLine&)>& each_line = {});
  /// Whether the latest command was answered by an error of the controller.
  [[nodiscard]] bool Refused() const { return refused_; }
  /// The same as Send for a homing cycle, which takes up to timeout_s of the clock.
  Result<void> SendHoming(double timeout_s, const std::stop_token& stop);

  /// A report that was asked for now. An alarm lock is no Error here, it is a state.
  Result<GrblStatus> Status(const std::stop_token& stop);
  /// A report, and the position in work coordinates. Errors also: kUnsupported where reports never say the offset.
  Result<GrblPosition> PositionInWork(GrblStatus& status, const std::stop_token& stop);

  /// A soft reset, and its banner. Errors: kDevice, kTimeout.
  Result<void> Reset(const std::stop_token& stop);
  /// Feed hold, standstill, soft reset: within a second of real time, whatever the controller does. True when it stood
  /// before it was reset, so that its position still holds.
  bool Stop() noexcept;

 private:
  GrblBoard(SerialLine line, Clock& clock) : line_(std::move(line)), clock_(clock) {}
  Result<void> ReadMachine(const std::stop_token& stop);
  /// Errors: kUnsupported: a startup block moves the machine: every reset, that of Stop too, would set it going.
  Result<void> CheckStartupBlocks(const std::stop_token& stop);
  /// The next line, looked at: alarms and banners are Errors. Nothing when none came within a slice.
  Result<std::optional<GrblLine>> Next();
  /// Waits for the ok of a command; `pause_s` of the clock pass between two looks at the line.
  Result<void> AwaitOk(std::string_view command, double timeout_s, double pause_s, const std::stop_token& stop,
                       const std::function<void(const GrblLine&)>& each_line);
  /// Reads until the line is silent for a slice: a board that reset itself when it was opened may have two banners.
  Result<void> TakeRestOfReset();
  bool HoldAndReset();
  [[nodiscard]] tl::unexpected<Error> NoAnswer(std::string_view to, double timeout_s) const;
  [[nodiscard]] tl::unexpected<Error> Stopped() const;

  SerialLine line_;
  Clock& clock_;
  GrblMachine machine_;
  bool refused_ = false;
  std::optional<GrblPosition> work_in_machine_;  ///< as last reported
};

}  // namespace rigcal
