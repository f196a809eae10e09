#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/descriptor.h"
#include "core/base/result.h"
#include "sim_fixtures/grbl/grbl_machine.h"

namespace rigcal::sim {

/// A simulated GRBL machine on a pseudo-terminal, served by a thread of its own. Its path is a serial device to whoever
/// opens it. Safe to use from several threads.
class GrblSimulator {
 public:
  /// The clock outlives it. Errors: kIo (no pseudo-terminal to be had).
  static Result<std::unique_ptr<GrblSimulator>> Start(Clock& clock);
  ~GrblSimulator();
  GrblSimulator(const GrblSimulator&) = delete;
  GrblSimulator& operator=(const GrblSimulator&) = delete;

  [[nodiscard]] const std::string& Path() const { return path_; }

  /// Calls `use` with the machine as it is now, while nothing else happens to it.
  void With(const std::function<void(GrblMachine&)>& use);
  /// Plays bytes to it that come from somebody else: a pendant, another program.
  void Push(const std::string& bytes);
  /// Called, without a lock, whenever it was sent something and said nothing.
  void WhenSilent(std::function<void()> call);

 private:
  GrblSimulator(Clock& clock, Descriptor master, Descriptor slave, std::string path);
  void Serve(const std::stop_token& stop);
  void Send(const std::string& bytes);

  GrblMachine machine_;
  Descriptor master_, slave_;  ///< the far end is held open too: the master of one that nobody has open reports errors
  std::string path_;
  std::mutex mutex_;
  std::function<void()> when_silent_;
  std::jthread thread_;  ///< last: it uses all of the above
};

}  // namespace rigcal::sim
