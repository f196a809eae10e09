#include "sim_fixtures/grbl/grbl_simulator.h"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

namespace rigcal::sim {
namespace {

constexpr int kSlice_ms = 10;  ///< between two looks at the time and the stop token

}  // namespace

Result<std::unique_ptr<GrblSimulator>> GrblSimulator::Start(Clock& clock) {
  Descriptor master(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  std::array<char, 128> path{};
  if (!master.Open() || grantpt(master.Number()) != 0 || unlockpt(master.Number()) != 0 ||
      ptsname_r(master.Number(), path.data(), path.size()) != 0) {
    return Fail(ErrorCode::kIo, "GRBL simulator: no pseudo-terminal is to be had");
  }
  Descriptor slave(open(path.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (!slave.Open()) return Fail(ErrorCode::kIo, "GRBL simulator: {} cannot be opened", path.data());
  termios raw{};
  tcgetattr(slave.Number(), &raw);
  cfmakeraw(&raw);
  tcsetattr(slave.Number(), TCSANOW, &raw);
  return std::unique_ptr<GrblSimulator>(
      new GrblSimulator(clock, std::move(master), std::move(slave), std::string(path.data())));
}

GrblSimulator::GrblSimulator(Clock& clock, Descriptor master, Descriptor slave, std::string path)
    : machine_(clock), master_(std::move(master)), slave_(std::move(slave)), path_(std::move(path)) {
  Send(machine_.PowerOn());
  thread_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
}

GrblSimulator::~GrblSimulator() {
  thread_.request_stop();
  thread_.join();
}

void GrblSimulator::With(const std::function<void(GrblMachine&)>& use) {
  const std::lock_guard lock(mutex_);
  Send(machine_.Elapse());
  use(machine_);
  Send(machine_.Elapse());
}

void GrblSimulator::Push(const std::string& bytes) {
  With([&](GrblMachine& machine) { Send(machine.Receive(bytes)); });
}

void GrblSimulator::WhenSilent(std::function<void()> call) {
  const std::lock_guard lock(mutex_);
  when_silent_ = std::move(call);
}

/// What finds no room is lost, as on a wire that nobody reads.
void GrblSimulator::Send(const std::string& bytes) {
  if (machine_.LineCut()) {
    master_.Close();
    slave_.Close();
  }
  if (!master_.Open() || bytes.empty()) return;
  [[maybe_unused]] const ssize_t written = write(master_.Number(), bytes.data(), bytes.size());
}

void GrblSimulator::Serve(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    pollfd waited{.fd = -1, .events = POLLIN, .revents = 0};
    {
      const std::lock_guard lock(mutex_);
      waited.fd = master_.Number();  // negative once it is cut: poll only waits then
    }
    const bool came = poll(&waited, 1, kSlice_ms) > 0;
    std::function<void()> silent;
    {
      const std::lock_guard lock(mutex_);
      std::array<char, 256> bytes{};
      const ssize_t count = came && master_.Open() ? read(master_.Number(), bytes.data(), bytes.size()) : 0;
      const std::string said = machine_.Receive({bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))});
      Send(said);
      if (count > 0 && said.empty()) silent = when_silent_;
    }
    if (silent) silent();
  }
}

}  // namespace rigcal::sim
