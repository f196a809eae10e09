#include "sim_fixtures/linuxcnc/linuxcnc_simulator.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>
#include <vector>

namespace rigcal::sim {
namespace {

constexpr int kSlice_ms = 10;  ///< between two looks at the time and the stop token
constexpr int kBacklog = 8;
constexpr int kSomebodyElse = -3;

}  // namespace

Result<std::unique_ptr<LinuxcncSimulator>> LinuxcncSimulator::Start(Clock& clock) {
  Descriptor listener(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(own);
  if (!listener.Open() || bind(listener.Number(), reinterpret_cast<sockaddr*>(&own), length) != 0 ||
      listen(listener.Number(), kBacklog) != 0 ||
      getsockname(listener.Number(), reinterpret_cast<sockaddr*>(&own), &length) != 0) {
    return Fail(ErrorCode::kIo, "LinuxCNC simulator: no port is to be had");
  }
  return std::unique_ptr<LinuxcncSimulator>(
      new LinuxcncSimulator(clock, std::move(listener), fmt::format("127.0.0.1:{}", ntohs(own.sin_port))));
}

LinuxcncSimulator::LinuxcncSimulator(Clock& clock, Descriptor listener, std::string address)
    : machine_(clock), listener_(std::move(listener)), address_(std::move(address)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
}

LinuxcncSimulator::~LinuxcncSimulator() {
  thread_.request_stop();
  thread_.join();
}

void LinuxcncSimulator::With(const std::function<void(LinuxcncMachine&)>& use) {
  const std::lock_guard lock(mutex_);
  machine_.Elapse();
  use(machine_);
  machine_.Elapse();
}

void LinuxcncSimulator::Push(const std::string& line) {
  With([&](LinuxcncMachine& machine) {
    RshClient somebody{.number = kSomebodyElse, .hello = true};
    (void)machine.Answer(somebody, "set enable EMCTOO");
    (void)machine.Answer(somebody, line);
  });
}

void LinuxcncSimulator::SetWire(RshWire wire) {
  const std::lock_guard lock(mutex_);
  wire_ = wire;
}

void LinuxcncSimulator::WhenSilent(std::function<void()> call) {
  const std::lock_guard lock(mutex_);
  when_silent_ = std::move(call);
}

/// What finds no room is lost, as with a client that does not read.
void LinuxcncSimulator::Send(const Connection& connection, std::string bytes) {
  if (bytes.empty()) return;
  if (wire_ == RshWire::kMerged) bytes = "get mode\r\n\r\n\n\rPROGRAM none\r\n" + bytes;
  const std::size_t chunk = wire_ == RshWire::kByteByByte ? 1 : bytes.size();
  for (std::size_t begin = 0; begin < bytes.size(); begin += chunk) {
    [[maybe_unused]] const ssize_t sent = send(connection.socket.Number(), bytes.data() + begin, chunk, MSG_NOSIGNAL);
  }
}

void LinuxcncSimulator::Take(Connection& connection, bool& silent) {
  std::array<char, 4096> bytes{};
  const ssize_t count = recv(connection.socket.Number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) connection.client.quit = true;
  if (count > 0) connection.received.append(bytes.data(), static_cast<std::size_t>(count));
  for (std::size_t end; (end = connection.received.find_first_of("\r\n")) != std::string::npos;) {
    const std::string line = connection.received.substr(0, end);
    connection.received.erase(0, end + 1);
    const std::string said = machine_.Answer(connection.client, line);
    silent = silent || (!line.empty() && machine_.Faults().silent);
    Send(connection, said);
  }
}

void LinuxcncSimulator::Accept() {
  Descriptor socket(accept4(listener_.Number(), nullptr, nullptr, SOCK_CLOEXEC));
  if (!socket.Open()) return;
  const int on = 1;
  setsockopt(socket.Number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  connections_.push_back({.socket = std::move(socket), .client = {.number = next_number_++}});
}

bool LinuxcncSimulator::ServeConnections() {
  const std::lock_guard lock(mutex_);
  machine_.Elapse();
  if (machine_.Gone()) listener_.Close();
  if (machine_.Cut()) {
    connections_.clear();
    machine_.SetCut(false);
  }
  if (listener_.Open()) Accept();
  bool silent = false;
  for (Connection& connection : connections_) Take(connection, silent);
  connections_.remove_if([](const Connection& connection) { return connection.client.quit; });
  return silent;
}

void LinuxcncSimulator::Serve(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::vector<pollfd> waited;
    {
      const std::lock_guard lock(mutex_);
      if (listener_.Open()) waited.push_back({.fd = listener_.Number(), .events = POLLIN, .revents = 0});
      for (const Connection& connection : connections_) {
        waited.push_back({.fd = connection.socket.Number(), .events = POLLIN, .revents = 0});
      }
    }
    poll(waited.data(), waited.size(), kSlice_ms);
    if (!ServeConnections()) continue;
    std::function<void()> call;
    {
      const std::lock_guard lock(mutex_);
      call = when_silent_;
    }
    if (call) call();
  }
}

}  // namespace rigcal::sim
