#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/clock.h"
#include "sim_fixtures/grbl/axis_motion.h"
#include "sim_fixtures/grbl/gcode_block.h"

namespace rigcal::sim {

/// What happens to the machine once its next motion has lasted a while.
enum class GrblTrouble { kLimitSwitch, kDoor, kFeedHold, kPowerCut, kLineCut };

/// What is wrong with a simulated machine.
struct GrblFaults {
  bool no_home = false;  ///< homing does not find a switch
  bool stuck = false;    ///< it says that it moves, and does not get on
  bool silent = false;   ///< it moves, and says nothing
  double miss = 0;       ///< every jog ends so far beyond its target, on X
  double startup = 0;    ///< after a reset and homing a startup block ($N0) moves X so far
  std::optional<GrblTrouble> in_motion;
  double in_motion_after_s = 0.3;
};

/// A controller with GRBL 1.1 and the machine behind it, written from the protocol (README.md): bytes in, bytes out,
/// and time by a clock. Not safe to use from several threads.
class GrblMachine {
 public:
  static constexpr double kHoming_s = 0.5;
  static constexpr std::size_t kReceiveBuffer = 128, kLongestLine = 80;

  explicit GrblMachine(Clock& clock);

  /// What a line to it takes; also switches it on.
  std::string PowerOn();
  /// Takes bytes and gives what it sends.
  std::string Receive(std::string_view bytes);
  /// Lets the time pass up to now; gives what it sends of itself.
  std::string Elapse();

  std::map<int, double>& Settings() { return settings_; }
  GrblFaults& Faults() { return faults_; }
  void SetDoor(bool open);
  void SetWorkOffset(const AxisValues& work_in_machine);
  void SetReceived(std::string* log) { log_ = log; }  ///< every whole line is added; may be null

  [[nodiscard]] bool Moving() const;
  [[nodiscard]] bool LineCut() const { return line_cut_; }
  [[nodiscard]] AxisValues PositionInWork() const;

 private:
  enum class State { kIdle, kRun, kJog, kHold, kAlarm, kDoor, kHome };

  void Take(char c);
  void TakeRealtime(char c);
  void TakeLines();
  void Execute(const std::string& line);
  void ExecuteSystem(const std::string& line);
  void ExecuteSetting(const std::string& line);
  void ExecuteJog(std::string_view line);
  void ExecuteGcode(const GcodeBlock& block);
  void SetOffset(const GcodeBlock& block);
  void StartHoming();
  void EndHoming();
  void AdvanceTo(double now_s);
  void MakeTrouble();
  void Hold();
  void Resume();
  void Reset();
  void Boot();
  void RunStartup();
  void Alarm(int number, bool waits_for_reset);
  void Report();
  void Say(const std::string& line) { out_ += line + "\r\n"; }
  void SayError(int number);
  void SayValues(const char* name, const AxisValues& values);
  [[nodiscard]] bool Waits(const std::string& line) const;
  [[nodiscard]] std::string StateName() const;
  [[nodiscard]] AxisValues TargetOf(const GcodeBlock& block, bool relative, bool inches) const;
  [[nodiscard]] bool BeyondTravel(const AxisValues& target) const;
  void Move(const AxisValues& target, double feed_per_min, State state);

  Clock& clock_;
  std::map<int, double> settings_;
  GrblFaults faults_;
  std::string* log_ = nullptr;

  State state_ = State::kIdle;
  bool door_open_ = false, waits_for_reset_ = false, line_cut_ = false;
  AxisMotion motion_;
  AxisValues offset_{}, g92_{};
  bool relative_ = false, inches_ = false;
  int motion_mode_ = 0;
  double feed_per_min_ = 0;
  double at_s_ = 0, moving_since_s_ = 0, homed_at_s_ = 0;
  int reports_to_offset_ = 0;
  std::string received_, out_;
};

}  // namespace rigcal::sim
