#include "tests/drivers/linuxcnc_real/tcp_relay.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>

namespace rigcal {
namespace {

constexpr int kSlice_ms = 5, kBacklog = 8;

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

/// Whether the connection lives.
bool Pass(const Descriptor& from, const Descriptor& to) {
  std::array<char, 4096> bytes{};
  const ssize_t count = recv(from.Number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count > 0) return send(to.Number(), bytes.data(), static_cast<std::size_t>(count), MSG_NOSIGNAL) == count;
  return count < 0 && errno == EAGAIN;
}

}  // namespace

TcpRelay::TcpRelay(int target_port)
    : target_port_(target_port), listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  sockaddr_in own = Loopback(0);
  socklen_t length = sizeof(own);
  bind(listener_.Number(), reinterpret_cast<sockaddr*>(&own), length);
  listen(listener_.Number(), kBacklog);
  getsockname(listener_.Number(), reinterpret_cast<sockaddr*>(&own), &length);
  address_ = fmt::format("127.0.0.1:{}", ntohs(own.sin_port));
  thread_ = std::jthread([this](const std::stop_token& stop) { Serve(stop); });
}

TcpRelay::~TcpRelay() {
  thread_.request_stop();
  thread_.join();
}

void TcpRelay::Cut() {
  const std::lock_guard lock(mutex_);
  pairs_.clear();
}

void TcpRelay::Serve(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::vector<pollfd> waited = {{.fd = listener_.Number(), .events = POLLIN, .revents = 0}};
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [client, server] : pairs_) {
        waited.push_back({.fd = client.Number(), .events = POLLIN, .revents = 0});
        waited.push_back({.fd = server.Number(), .events = POLLIN, .revents = 0});
      }
    }
    poll(waited.data(), waited.size(), kSlice_ms);
    const std::lock_guard lock(mutex_);
    Descriptor client(accept4(listener_.Number(), nullptr, nullptr, SOCK_CLOEXEC));
    if (client.Open()) {
      Descriptor server(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
      const sockaddr_in target = Loopback(target_port_);
      if (connect(server.Number(), reinterpret_cast<const sockaddr*>(&target), sizeof(target)) == 0) {
        pairs_.emplace_back(std::move(client), std::move(server));
      }
    }
    std::erase_if(pairs_,
                  [](const auto& pair) { return !Pass(pair.first, pair.second) || !Pass(pair.second, pair.first); });
  }
}

}  // namespace rigcal
