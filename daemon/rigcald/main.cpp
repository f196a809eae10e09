#include <fmt/format.h>
#include <pthread.h>
#include <systemd/sd-daemon.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdint>
#include <exception>
#include <opencv2/core/utility.hpp>

#include "daemon/service/log.h"
#include "daemon/service/service.h"

namespace rigcal {
namespace {

constexpr int kExitFailed = 1, kExitBadInput = 2;
constexpr double kStatusEveryS = 5;         ///< how often `systemctl status` learns where the jobs are
constexpr double kWatchdogShare = 1.0 / 3;  ///< of WatchdogSec: two may be late before the service is taken for dead

/// The signals that a service is led with, read by Await; blocked in every thread that starts later.
class Signals {
 public:
  Signals() {
    sigemptyset(&set_);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set_, signal);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }
  /// The next one, or 0 after a while.
  int Await(double seconds) {
    const auto whole = static_cast<time_t>(seconds);
    const timespec wait{.tv_sec = whole, .tv_nsec = static_cast<long>(1e9 * (seconds - static_cast<double>(whole)))};
    return std::max(0, sigtimedwait(&set_, nullptr, &wait));
  }

 private:
  sigset_t set_{};
};

/// How long between two signs of life.
double PauseS() {
  std::uint64_t watchdog_us = 0;
  if (sd_watchdog_enabled(0, &watchdog_us) <= 0) return kStatusEveryS;
  return std::min(kStatusEveryS, kWatchdogShare * 1e-6 * static_cast<double>(watchdog_us));
}

void Notify(const std::string& state) {
  sd_notify(0, state.c_str());
}

void Reload(Service& service, const ServiceOptions& options) {
  Notify("RELOADING=1");
  const Result<void> reloaded = service.Reload();
  if (reloaded) Log(LogPriority::kNotice, options.rig_file.string() + ": read again");
  if (!reloaded) Log(LogPriority::kError, "the rig file of before stays in use: " + reloaded.error().message);
  Notify("READY=1");
}

int Serve(const ServiceOptions& options) {
  Signals signals;
  cv::setNumThreads(1);  // --threads counts ours, which run over pictures; OpenCV's own would come on top of them
  Result<std::unique_ptr<Service>> service = Service::Start(options);
  if (!service) {
    Log(LogPriority::kError, service.error().message);
    return kExitFailed;
  }
  for (const std::string& address : (*service)->Addresses()) Log(LogPriority::kNotice, "answers at " + address);
  Notify("READY=1");
  for (const double pause_s = PauseS();;) {
    Notify("STATUS=" + (*service)->StatusText());
    if ((*service)->IsHealthy()) Notify("WATCHDOG=1");
    const int signal = signals.Await(pause_s);
    if (signal == SIGHUP) Reload(**service, options);
    if (signal == SIGTERM || signal == SIGINT) break;
  }
  Notify("STOPPING=1");
  service->reset();
  Log(LogPriority::kNotice, "stopped");
  return 0;
}

int Main(int argc, char** argv) {
  ServiceOptions options{.state = "/var/lib/rigcal", .socket = DefaultSocket(), .run_folder = DefaultRunFolder()};
  CLI::App app("rigcald owns the devices of a rig, runs its jobs and publishes its calibration.", "rigcald");
  app.add_option("--config", options.rig_file, "rig.toml (docs/rig.md)")->required();
  app.add_option("--state", options.state, "Folder of the store, the journal and the recordings")
      ->capture_default_str();
  app.add_option("--socket", options.socket, "Socket that requests come by")->capture_default_str();
  app.add_option("--run-dir", options.run_folder, "Folder that says who holds a rig")->capture_default_str();
  constexpr int kMaxThreads = 256;
  app.add_option("--threads", options.num_threads, "Threads of the stages; 0: one for each processor")
      ->check(CLI::Range(0, kMaxThreads))
      ->capture_default_str();
  TcpListen tcp;
  CLI::Option* listen = app.add_option("--listen", tcp.address, "HOST:PORT to answer at, too: by TLS, with a token");
  for (CLI::Option* option :
       {app.add_option("--token-file", tcp.token, "File with the bearer token that clients must send"),
        app.add_option("--tls-certificate", tcp.certificate, "Certificate, PEM"),
        app.add_option("--tls-key", tcp.key, "Its key, PEM")}) {
    listen->needs(option);
    option->needs(listen);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitBadInput;
  }
  if (!tcp.address.empty()) options.tcp = tcp;
  return Serve(options);
}

}  // namespace
}  // namespace rigcal

int main(int argc, char** argv) {
  try {
    return rigcal::Main(argc, argv);
  } catch (const std::exception& bug) {
    rigcal::Log(rigcal::LogPriority::kError, fmt::format("internal error: {}", bug.what()));
    return rigcal::kExitFailed;
  }
}
