#pragma once

#include <array>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/base/socket_address.h"
#include "drivers/line_connection.h"

namespace rigcal {

/// The axes of linuxcncrsh's positions, in their order. It does not tell U, V and W.
inline constexpr std::string_view kRshAxisLetters = "XYZABC";
/// Machine coordinates: X, Y, Z in millimetres, A, B, C in degrees.
using RshPosition = std::array<double, kRshAxisLetters.size()>;

/// What LinuxCNC says of itself at one moment.
struct RshState {
  bool emergency_stop = false, power = false;
  std::string mode;     ///< "MANUAL", "AUTO", "MDI"
  std::string program;  ///< "IDLE", "RUNNING", "PAUSED"; also of a move by MDI
  RshPosition at{};
};

/// Whether a session only asks, or also commands. linuxcncrsh obeys one connection, the last that asked for it.
enum class RshRole { kLook, kControl };

/// The conversation with linuxcncrsh, the text interface of LinuxCNC (README.md). Every Error names the address. Codes
/// beside those of each function: kDevice (connection lost, refused), kTimeout (no answer), kCancelled.
class RshSession {
 public:
  static constexpr double kConnect_s = 3;
  static constexpr double kAnswer_s = 3;  ///< answers come within 0.2 s; a program that starts is silent for 1 s
  static constexpr double kStop_s = 0.9;  ///< of Stop: below its one second
  static constexpr int kMostMessages = 32;

  /// Connects and says hello. Errors also: kBadInput (no such host).
  static Result<RshSession> Open(const SocketAddress& address, RshRole role, Clock& clock, const std::stop_token& stop);

  /// Connects again where the connection is lost.
  Result<void> Restore(const std::stop_token& stop);

  /// The value of one thing, "get ...". Errors also: kUnsupported (it does not know it).
  Result<std::string> Get(std::string_view what, const std::stop_token& stop);
  /// "set ...". Errors also: kDevice: not obeyed, with the reason where it is one of control.
  Result<void> Set(std::string_view command, const std::stop_token& stop);

  Result<RshState> State(const std::stop_token& stop);
  /// Its messages to the operator since they were last asked for, on one line; empty: none. Each is told once.
  Result<std::string> Messages(const std::stop_token& stop);

  /// Aborts whatever moves the machine, taking control and connecting again where that is needed; within kStop_s of
  /// real time. True when the machine was seen to stand.
  bool Stop() noexcept;

  /// "linuxcnc: HOST:PORT"
  [[nodiscard]] const std::string& Name() const { return name_; }
  /// As its hello says: "EMCNETSVR 1.1"
  [[nodiscard]] const std::string& Server() const { return server_; }

 private:
  RshSession(SocketAddress address, RshRole role, Clock& clock);
  Result<void> SayHello(const std::stop_token& stop);
  Result<RshPosition> Position(const std::stop_token& stop);
  Result<std::string> GetBy(Clock& clock, double timeout_s, std::string_view what, const std::stop_token& stop);
  Result<void> Send(std::string_view request);
  /// How the line of an answer begins, in one way or another; empty: none.
  struct Begins {
    std::string_view one, other;
  };
  /// Sends a request and hands back the next line that begins so; what comes before it is passed over. Without one the
  /// connection is given up: a late answer would be taken for that of a later request.
  Result<std::string> Ask(std::string_view request, const Begins& begins, Clock& clock, double timeout_s,
                          const std::stop_token& stop);
  bool AbortAndStand();
  [[nodiscard]] tl::unexpected<Error> Lost();

  SocketAddress address_;
  RshRole role_;
  Clock* clock_;
  std::string name_, server_;
  double mm_per_unit_ = 1;
  std::optional<LineConnection> line_;  ///< none: lost
};

}  // namespace rigcal
