#include "drivers/arm/listener.h"

#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <charconv>
#include <memory>
#include <system_error>

namespace rigcal {
namespace {

constexpr int kBacklog = 8;  ///< programs that wait to be accepted; more than one is a mistake anyway

/// The address in numbers; never asks a name server, which might take its time.
std::optional<SocketAddress> AddressOf(const sockaddr_storage& storage, socklen_t length) {
  char host[NI_MAXHOST] = {}, port[NI_MAXSERV] = {};
  const int failed = getnameinfo(reinterpret_cast<const sockaddr*>(&storage), length, host, sizeof(host), port,
                                 sizeof(port), NI_NUMERICHOST | NI_NUMERICSERV);
  if (failed != 0) return std::nullopt;
  SocketAddress address{.host = host};
  const std::string_view digits = port;
  std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
  return address;
}

tl::unexpected<Error> CannotListen(const SocketAddress& address, const std::string& why) {
  return Fail(ErrorCode::kDevice, "arm: cannot listen on {}: {}", ToText(address), why);
}

std::string LastReason() {
  return errno == EADDRINUSE ? "the port is in use by another program" : std::generic_category().message(errno);
}

}  // namespace

Result<Listener> Listener::Open(const SocketAddress& address) {
  const std::string host = address.host == "localhost" ? "127.0.0.1" : address.host;
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(address.port).c_str(), &hints, &found) != 0) {
    return CannotListen(address, "the host must be an address of this machine in numbers, or localhost");
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, freeaddrinfo);
  Descriptor socket(::socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (socket.Number() < 0) return CannotListen(address, LastReason());
  // The port of a capture that has just ended can be taken again; one that is listened on cannot.
  const int on = 1;
  setsockopt(socket.Number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  if (bind(socket.Number(), found->ai_addr, found->ai_addrlen) != 0 || listen(socket.Number(), kBacklog) != 0) {
    return CannotListen(address, LastReason());
  }
  sockaddr_storage own{};
  socklen_t length = sizeof(own);
  if (getsockname(socket.Number(), reinterpret_cast<sockaddr*>(&own), &length) != 0) {
    return CannotListen(address, LastReason());
  }
  return Listener(std::move(socket), AddressOf(own, length).value_or(address));
}

std::optional<LineConnection> Listener::Accept() {
  sockaddr_storage peer{};
  socklen_t length = sizeof(peer);
  Descriptor socket(
      accept4(socket_.Number(), reinterpret_cast<sockaddr*>(&peer), &length, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (socket.Number() < 0) return std::nullopt;  // nobody, or somebody who has gone again
  const std::optional<SocketAddress> address = AddressOf(peer, length);
  return LineConnection(std::move(socket), address ? ToText(*address) : "an unknown address");
}

}  // namespace rigcal
