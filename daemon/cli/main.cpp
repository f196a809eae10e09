#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "daemon/cli/command.h"

namespace rigcal {
namespace {

/// Waits for SIGINT or SIGTERM in a thread of its own and turns them into a stop request. Must live before other
/// threads start, so that they inherit the blocked mask.
class StopOnSignal {
 public:
  StopOnSignal() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    waiter_ = std::jthread([this](const std::stop_token& end) {
      while (!end.stop_requested()) {
        constexpr timespec kPoll{.tv_sec = 0, .tv_nsec = 100'000'000};
        if (sigtimedwait(&signals_, nullptr, &kPoll) > 0) stop_.request_stop();
      }
    });
  }
  ~StopOnSignal() {
    waiter_.request_stop();
    pthread_kill(waiter_.native_handle(), SIGTERM);  // it ends at once, not at its next poll
  }
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;
  [[nodiscard]] std::stop_token Token() const { return stop_.get_token(); }

 private:
  sigset_t signals_{};
  std::stop_source stop_;
  std::jthread waiter_;
};

int Main(int argc, char** argv) {
  const StopOnSignal signals;
  cv::setNumThreads(1);  // --threads counts ours, which run over pictures; OpenCV's own would come on top of them
  CommandSession session;
  session.stop = signals.Token();
  session.on_terminal = isatty(STDERR_FILENO) != 0;
  CLI::App app("rigcal keeps the cameras of an object-scanning studio calibrated.", "rigcal");
  app.require_subcommand(1);
  AddRefineCommand(app, session);
  AddValidateCommand(app, session);
  AddMvsCommand(app, session);
  AddCompareCommand(app, session);
  AddExportCommand(app, session);
  AddRecordingCommand(app, session);
  AddRigCommand(app, session);
  AddCaptureCommand(app, session);
  AddDevicesCommand(app, session);
  AddSeedCommand(app, session);
  AddChartCommand(app, session);
  AddHistoryCommands(app, session);
  AddPublishCommands(app, session);
  AddDriftCommand(app, session);
  AddStoreCommand(app, session);
  AddServiceCommands(app, session);
  AddSimCommand(app, session);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitAccepted : kExitBadInput;
  }
  return session.exit_status;
}

}  // namespace
}  // namespace rigcal

int main(int argc, char** argv) {
  try {
    return rigcal::Main(argc, argv);
  } catch (const std::exception& bug) {
    fmt::print(stderr, "rigcal: internal error: {}\n", bug.what());
    return rigcal::kExitInternal;
  }
}
