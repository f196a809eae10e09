#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// Debian's LinuxCNC (linuxcnc-uspace) with linuxcncrsh and the machine of studio.ini, as an ordinary user in a folder
/// of its own. Ends with its object.
class LinuxcncProcess {
 public:
  /// Returns once linuxcncrsh can be connected to. Errors: kUnsupported: it cannot run here, and why; kTimeout.
  static Result<std::unique_ptr<LinuxcncProcess>> Start();
  ~LinuxcncProcess();
  LinuxcncProcess(const LinuxcncProcess&) = delete;
  LinuxcncProcess& operator=(const LinuxcncProcess&) = delete;

  [[nodiscard]] int Port() const { return port_; }

  /// Sets a pin of the machine: limit switches, the emergency stop's chain.
  void SetPin(const std::string& pin, bool on) const;
  /// Asks or commands by a connection of its own, which takes control for a command; hands back the last answer.
  [[nodiscard]] std::string Say(const std::string& line) const;

 private:
  LinuxcncProcess(std::filesystem::path folder, int port, pid_t process)
      : folder_(std::move(folder)), port_(port), process_(process) {}

  std::filesystem::path folder_;
  int port_;
  pid_t process_;
};

}  // namespace rigcal
