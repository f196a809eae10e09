#include "drivers/connect_to.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>
#include <system_error>

namespace rigcal {
namespace {

constexpr int kSlice_ms = 20;  ///< between two looks at the clock and the stop token

tl::unexpected<Error> CannotConnect(int failure) {
  return Fail(ErrorCode::kDevice, "cannot be connected to: {}", std::generic_category().message(failure));
}

}  // namespace

Result<LineConnection> ConnectTo(const SocketAddress& address, double timeout_s, Clock& clock,
                                 const std::stop_token& stop) {
  const std::string host = address.host == "localhost" ? "127.0.0.1" : address.host;
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(address.port).c_str(), &hints, &found) != 0) {
    return Fail(ErrorCode::kBadInput, "the host must be an address in numbers, or localhost");
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, freeaddrinfo);
  Descriptor socket(::socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket.Open()) return CannotConnect(errno);
  const int on = 1;
  setsockopt(socket.Number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));  // a stop must not wait for an answer
  if (connect(socket.Number(), found->ai_addr, found->ai_addrlen) != 0 && errno != EINPROGRESS) {
    return CannotConnect(errno);
  }
  const double end_s = clock.NowS() + timeout_s;
  while (true) {
    pollfd waited{.fd = socket.Number(), .events = POLLOUT, .revents = 0};
    if (poll(&waited, 1, kSlice_ms) > 0) break;
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "was stopped on request");
    if (clock.NowS() > end_s) return Fail(ErrorCode::kTimeout, "no connection within {} s", timeout_s);
  }
  int failure = 0;
  socklen_t length = sizeof(failure);
  getsockopt(socket.Number(), SOL_SOCKET, SO_ERROR, &failure, &length);
  if (failure != 0) return CannotConnect(failure);
  return LineConnection(std::move(socket), ToText(address));
}

}  // namespace rigcal
