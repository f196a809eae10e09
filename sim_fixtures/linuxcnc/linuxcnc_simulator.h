#pragma once

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/descriptor.h"
#include "core/base/result.h"
#include "sim_fixtures/linuxcnc/linuxcnc_machine.h"

namespace rigcal::sim {

/// How answers reach the wire: as they are, in pieces of one byte, or behind lines that nobody asked for.
enum class RshWire { kPlain, kByteByByte, kMerged };

/// A simulated linuxcncrsh that listens on a free port of 127.0.0.1, served by a thread of its own. Safe to use from
/// several threads.
class LinuxcncSimulator {
 public:
  /// The clock outlives it. Errors: kIo (no port to be had).
  static Result<std::unique_ptr<LinuxcncSimulator>> Start(Clock& clock);
  ~LinuxcncSimulator();
  LinuxcncSimulator(const LinuxcncSimulator&) = delete;
  LinuxcncSimulator& operator=(const LinuxcncSimulator&) = delete;

  /// "127.0.0.1:PORT"
  [[nodiscard]] const std::string& Address() const { return address_; }

  /// Calls `use` with the machine as it is now, while nothing else happens to it.
  void With(const std::function<void(LinuxcncMachine&)>& use);
  /// Plays a line to it that comes from another connection, which takes control for it.
  void Push(const std::string& line);
  void SetWire(RshWire wire);
  /// Called, without a lock, whenever it was sent something and said nothing.
  void WhenSilent(std::function<void()> call);

 private:
  struct Connection {
    Descriptor socket;
    RshClient client;
    std::string received;
  };

  LinuxcncSimulator(Clock& clock, Descriptor listener, std::string address);
  void Serve(const std::stop_token& stop);
  /// Reads from the connections; whether something was said to it that it left without an answer.
  bool ServeConnections();
  void Take(Connection& connection, bool& silent);
  void Send(const Connection& connection, std::string bytes);
  void Accept();

  LinuxcncMachine machine_;
  Descriptor listener_;
  std::string address_;
  std::mutex mutex_;
  std::function<void()> when_silent_;
  RshWire wire_ = RshWire::kPlain;
  std::list<Connection> connections_;
  int next_number_ = 0;
  std::jthread thread_;  ///< last: it uses all of the above
};

}  // namespace rigcal::sim
