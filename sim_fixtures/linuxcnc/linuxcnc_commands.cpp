#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>

#include "sim_fixtures/linuxcnc/linuxcnc_machine.h"

namespace rigcal::sim {
namespace {

constexpr std::string_view kPassword = "EMC", kEnablePassword = "EMCTOO";
// linuxcncrsh ends what it answers to `get` and `hello` in one way, to `set` in the other, and a refused `get` twice.
constexpr std::string_view kEnd = "\r\n", kSetEnd = "\n\r";

std::string Upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::vector<std::string> WordsOf(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t begin = line.find_first_not_of(' '); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find(' ', begin), line.size());
    words.emplace_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(' ', end);
  }
  return words;
}

std::string OnOff(bool on) {
  return on ? "ON" : "OFF";
}

}  // namespace

std::string LinuxcncMachine::Answer(RshClient& client, const std::string& line) {
  Elapse();
  const std::vector<std::string> words = WordsOf(line);
  if (words.empty()) return "";
  std::string out = client.echo && client.hello ? fmt::format("{}{}", line, kEnd) : "";
  const std::string command = Upper(words[0]);
  if (log_ != nullptr && command != "GET") log_->push_back(line);
  if (command == "HELLO") {
    const bool good = words.size() >= 4 && words[1] == kPassword;
    client.hello = client.hello || good;
    out += fmt::format("HELLO {}{}", good ? "ACK EMCNETSVR 1.1" : "NAK", kEnd);
  } else if (command == "GET") {
    out += Get(client, words);
  } else if (command == "SET") {
    const std::string what = words.size() > 1 ? Upper(words[1]) : "";
    const bool obeys = faults_.refused != what && Set(client, words, line);
    const std::string name = what.empty() ? "" : ' ' + what;
    if (!obeys) out += fmt::format("SET{} NAK{}", name, kSetEnd);
    if (obeys && client.verbose) out += fmt::format("SET{} ACK{}", name, kSetEnd);
  } else if (command == "QUIT") {
    client.quit = true;
  }
  Elapse();
  return faults_.silent ? "" : out;
}

std::string LinuxcncMachine::Get(const RshClient& client, const std::vector<std::string>& words) {
  if (words.size() < 2) return fmt::format("GET NAK{}", kEnd);
  const std::string what = Upper(words[1]);
  if (what == "ERROR") {
    if (messages_.empty()) return fmt::format("ERROR OK{}", kEnd);
    std::string message = std::move(messages_.front());
    messages_.pop_front();
    return fmt::format("ERROR {}{}", message, kEnd);
  }
  const std::optional<std::string> value = ValueOf(client, what);
  return value ? fmt::format("{} {}{}", what, *value, kEnd) : fmt::format("GET {} NAK{}{}", what, kEnd, kEnd);
}

std::optional<std::string> LinuxcncMachine::ValueOf(const RshClient& client, const std::string& what) const {
  if (what == "ECHO") return OnOff(client.echo);
  if (what == "ENABLE") return OnOff(enabled_ == client.number);
  if (what == "ESTOP") return OnOff(emergency_stop_);
  if (what == "MACHINE") return OnOff(power_);
  if (what == "MODE") return mode_;
  if (what == "PROGRAM_STATUS") return Paused() ? "PAUSED" : moves_.empty() ? "IDLE" : "RUNNING";
  if (what == "ABS_ACT_POS") return PositionText();
  if (what == "JOINT_POS") {
    // Homing joints move, though nobody sees where: how long it takes is enough.
    const double homing = homing_ ? homing_until_s_ - at_s_ : 0;
    return fmt::format("{:.6f} {:.6f} {:.6f} {:.6f} 0.000000 0.000000", at_[0], at_[2], at_[5], homing);
  }
  // Six joints are told, however many there are.
  const auto words = [](const auto& of) {
    return fmt::format("{} {} {} {} {} {}", of(0), of(1), of(2), of(3), of(4), of(5));
  };
  if (what == "JOINT_HOMED") return words([&](std::size_t joint) { return joint < 3 && homed_[joint] ? "YES" : "NO"; });
  if (what == "JOINT_LIMIT") return words([&](int joint) { return joint == 2 && at_limit_ ? "MAXHARD" : "OK"; });
  if (what == "JOINT_FAULT") return words([](int) { return "OK"; });
  if (what == "USER_LINEAR_UNITS") return mm_per_unit_ == 1 ? "MM" : "INCH";
  if (what == "USER_ANGULAR_UNITS") return "DEG";
  return std::nullopt;
}

std::string LinuxcncMachine::PositionText() const {
  return fmt::format("{:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f}", at_[0] / mm_per_unit_, at_[1] / mm_per_unit_,
                     at_[2] / mm_per_unit_, at_[3], at_[4], at_[5]);
}

bool LinuxcncMachine::Set(RshClient& client, const std::vector<std::string>& words, const std::string& line) {
  if (words.size() < 2) return false;
  const std::string what = Upper(words[1]), value = words.size() > 2 ? Upper(words[2]) : "";
  if (what == "ECHO" || what == "VERBOSE") {
    if (value != "ON" && value != "OFF") return false;
    (what == "ECHO" ? client.echo : client.verbose) = value == "ON";
    return true;
  }
  if (what == "ENABLE") {
    if (value != "OFF" && (words.size() < 3 || words[2] != kEnablePassword)) return false;
    enabled_ = value == "OFF" ? -1 : client.number;
    return true;
  }
  if (enabled_ != client.number) return false;
  const std::size_t begin = words.size() > 2 ? line.find(words[2], line.find(words[1]) + words[1].size()) : line.size();
  return SetMachine(what, value, line.substr(begin));
}

bool LinuxcncMachine::SetMachine(const std::string& what, const std::string& value, const std::string& rest) {
  if (what == "ESTOP") {
    if (value == "ON") SetEmergencyStop(true, held_);
    if (value == "OFF" && !held_) emergency_stop_ = false;
    return value == "ON" || value == "OFF";
  }
  if (what == "MACHINE") {
    if (value == "OFF") SwitchOff();
    if (value == "ON" && at_limit_) messages_.emplace_back("joint 2 on limit switch error");
    if (value == "ON") power_ = !emergency_stop_ && !at_limit_ && !faults_.no_power;
    return value == "ON" || value == "OFF";
  }
  if (what != "MODE" && what != "HOME" && what != "MDI" && what != "ABORT") return false;
  if (!power_) return false;
  if (what == "MODE") return SetMode(value);
  if (what == "HOME") SetHome(value);
  if (what == "MDI") RunMdi(rest);
  if (what == "ABORT") StopMotion();
  return true;
}

bool LinuxcncMachine::SetMode(const std::string& value) {
  if (value != "MANUAL" && value != "AUTO" && value != "MDI") return false;
  if (homing_) return true;  // it stays as it is then
  StopMotion();
  mode_ = value;
  return true;
}

void LinuxcncMachine::SetHome(const std::string& value) {
  if (value != "-1") return;
  if (mode_ != "MANUAL") {
    messages_.push_back(fmt::format("can't do that (EMC_JOINT_HOME:123) in {} mode", mode_));
  } else if (Homed()) {
    messages_.emplace_back("must be in joint mode to home");
  } else {
    homing_ = true;
    homing_until_s_ = at_s_ + kHoming_s;
  }
}

}  // namespace rigcal::sim
