#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

namespace rigcal {

/// GRBL has three axes, X, Y and Z, in this order in all its messages.
inline constexpr int kNumGrblAxes = 3;
inline constexpr std::string_view kGrblAxisLetters = "XYZ";

/// A position in the controller's own unit, "millimetre": of an axis that turns it is a degree.
using GrblPosition = std::array<double, kNumGrblAxes>;

enum class GrblState { kIdle, kRun, kJog, kHold, kAlarm, kDoor, kCheck, kHome, kSleep };

/// One status report, the answer to '?'.
struct GrblStatus {
  GrblState state = GrblState::kIdle;
  std::optional<int> substate;  ///< of Hold and Door: 0 and 1 at rest, beyond still moving (Hold: from 1 on)
  std::optional<GrblPosition> in_machine, in_work;  ///< MPos or WPos: one of them, as setting $10 says
  std::optional<GrblPosition> work_in_machine;      ///< WCO, now and then: in_work = in_machine - work_in_machine
  std::string pins;                                 ///< letters of the inputs that are on: X Y Z limits, D door, ...

  /// Whether nothing moves, nor will move by itself.
  [[nodiscard]] bool AtRest() const;
};

enum class GrblLineKind { kOk, kError, kAlarm, kBanner, kStatus, kSetting, kOther };

/// One line that the controller sent.
struct GrblLine {
  GrblLineKind kind = GrblLineKind::kOther;
  int number = 0;     ///< of an error, an alarm or a setting; 0 where it had none
  std::string text;   ///< the version of a banner ("1.1h"), the value of a setting, else the line itself
  GrblStatus status;  ///< where the kind is kStatus
};

/// Never fails: what is no message of GRBL, or half of one, is of the kind kOther.
GrblLine ParseGrblLine(std::string_view line);

/// What an alarm or an error means, in a few words (GRBL 1.1, its pages on the interface).
std::string_view GrblAlarmMeaning(int number);
std::string_view GrblErrorMeaning(int number);
std::string_view NameOf(GrblState state);

/// Cuts what comes from the wire into lines, wherever the reads cut it. A line that is longer than any of GRBL is
/// dropped whole: what it holds stays bounded.
class LineSplitter {
 public:
  static constexpr std::size_t kLongestLine = 255;  ///< GRBL's longest are settings and reports of about 100

  void Add(std::string_view bytes);
  /// The next line that is not empty, without its end.
  std::optional<std::string> Next();

 private:
  std::string begun_;
  bool too_long_ = false;
  std::deque<std::string> lines_;
};

}  // namespace rigcal
