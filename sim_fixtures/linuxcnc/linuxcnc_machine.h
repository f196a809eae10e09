#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/clock.h"
#include "sim_fixtures/linuxcnc/mdi_line.h"

namespace rigcal::sim {

/// What happens once the next motion has lasted a while.
enum class LinuxcncTrouble {
  kEmergencyStop,  ///< of the machine, by hand: it cannot be reset
  kLimit,          ///< joint 2's limit switch: the power goes off
  kPowerOff,
  kPause,      ///< by somebody else
  kTakenOver,  ///< another program takes control
  kCut,        ///< all connections end
  kGone,       ///< and none is accepted any more
};

/// What is wrong with a simulated machine.
struct LinuxcncFaults {
  bool no_home = false;      ///< homing does not find a switch
  bool no_sequence = false;  ///< joint 1 has no HOME_SEQUENCE
  bool no_power = false;     ///< the drives do not come up
  bool stuck = false;        ///< it says that it moves, and does not get on
  bool silent = false;       ///< it moves, and says nothing
  double miss = 0;           ///< every move ends so far beyond its target, on C, degrees
  std::string refused;       ///< this set command is refused: "MDI"
  std::optional<LinuxcncTrouble> in_motion;
  double in_motion_after_s = 0.3;
};

/// One connection to linuxcncrsh, as it keeps it.
struct RshClient {
  int number = 0;
  bool hello = false, echo = true, verbose = false, quit = false;
};

/// LinuxCNC with linuxcncrsh and the machine behind it, an XZ gantry with a rotary C axis (joints 0, 1, 2): lines in,
/// bytes out, and time by a clock. Written from sessions with the real one (README.md). Not safe to use from several
/// threads.
class LinuxcncMachine {
 public:
  static constexpr double kHoming_s = 0.5;  ///< of each joint

  explicit LinuxcncMachine(Clock& clock);

  /// What it answers to a line of a connection.
  std::string Answer(RshClient& client, const std::string& line);
  /// Lets the time pass up to now.
  void Elapse();

  LinuxcncFaults& Faults() { return faults_; }
  /// The emergency stop, and whether it is held so that it cannot be reset.
  void SetEmergencyStop(bool on, bool held);
  void SetInches() { mm_per_unit_ = 25.4; }
  void SetPosition(char axis, double value);
  /// Every line that is no question is added; may be null.
  void SetReceived(std::vector<std::string>* log) { log_ = log; }

  [[nodiscard]] bool Moving() const { return !Paused() && (!moves_.empty() || homing_); }
  [[nodiscard]] bool Cut() const { return cut_; }
  void SetCut(bool cut) { cut_ = cut; }
  [[nodiscard]] bool Gone() const { return gone_; }
  [[nodiscard]] bool Power() const { return power_; }
  /// Millimetres or degrees.
  [[nodiscard]] double Position(char axis) const;

 private:
  struct Move {
    MdiPosition target{};
    double left_s = 0;
  };

  std::string Get(const RshClient& client, const std::vector<std::string>& words);
  std::optional<std::string> ValueOf(const RshClient& client, const std::string& what) const;
  /// Whether it obeys.
  bool Set(RshClient& client, const std::vector<std::string>& words, const std::string& line);
  bool SetMachine(const std::string& what, const std::string& value, const std::string& rest);
  bool SetMode(const std::string& value);
  void SetHome(const std::string& value);
  void RunMdi(const std::string& text);
  void MakeTrouble();
  void AdvanceTo(double now_s);
  void AdvanceHoming(double now_s);
  void StopMotion();
  void SwitchOff();
  [[nodiscard]] bool Homed() const;
  [[nodiscard]] bool Paused() const { return paused_ && !moves_.empty(); }
  [[nodiscard]] std::string PositionText() const;

  Clock& clock_;
  LinuxcncFaults faults_;
  std::vector<std::string>* log_ = nullptr;
  double mm_per_unit_ = 1;

  bool emergency_stop_ = true, held_ = false, power_ = false, paused_ = false, cut_ = false, gone_ = false;
  bool at_limit_ = false;
  std::string mode_ = "MANUAL";
  std::array<bool, 3> homed_{};
  bool homing_ = false;
  double homing_until_s_ = 0;
  MdiModes modes_;
  MdiPosition at_{};
  std::deque<Move> moves_;
  std::deque<std::string> messages_;
  int enabled_ = -1;  ///< the connection that it obeys
  double at_s_ = 0, moving_since_s_ = 0;
};

}  // namespace rigcal::sim
