#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <linux/sockios.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <chrono>
#include <stdexcept>
#include <string>

#include "core/base/clock.h"
#include "core/base/descriptor.h"
#include "core/base/result.h"
#include "core/base/socket_address.h"
#include "tests/support/fake_clock.h"

// What plays the program of a robot arm against drivers/arm.
namespace rigcal {

inline constexpr double kHang_s = 60;  ///< catches what would not end, on a machine however busy

template <typename T>
std::string MessageOf(const Result<T>& result) {
  return result ? "no error" : result.error().message;
}

/// Time that passes a little for others too whenever somebody waits: what is sent on a loopback arrives.
class PatientClock final : public Clock {
 public:
  [[nodiscard]] double NowS() const override { return fake_.NowS(); }
  bool Wait(double seconds, const std::stop_token& stop) override {
    poll(nullptr, 0, 1);
    return fake_.Wait(seconds, stop);
  }
  FakeClock& Fake() { return fake_; }

 private:
  FakeClock fake_;
};

/// A program that connects to the driver. Its waits are for events, with a bound for hangs.
class Program {
 public:
  explicit Program(const SocketAddress& address) {
    const bool v6 = address.host.find(':') != std::string::npos;
    socket_ = Descriptor(socket(v6 ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto port = htons(static_cast<std::uint16_t>(address.port));
    sockaddr_in to{.sin_family = AF_INET, .sin_port = port};
    sockaddr_in6 to6{.sin6_family = AF_INET6, .sin6_port = port};
    inet_pton(v6 ? AF_INET6 : AF_INET, address.host.c_str(),
              v6 ? static_cast<void*>(&to6.sin6_addr) : static_cast<void*>(&to.sin_addr));
    const auto* any = v6 ? reinterpret_cast<const sockaddr*>(&to6) : reinterpret_cast<const sockaddr*>(&to);
    connected_ = connect(socket_.Number(), any, v6 ? sizeof(to6) : sizeof(to)) == 0;
  }
  [[nodiscard]] bool Connected() const { return connected_; }
  /// Has come to the other side when it returns, as SayNoMore has.
  void Say(const std::string& text) {
    EXPECT_EQ(send(socket_.Number(), text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    AwaitArrival();
  }
  /// The next line; "closed" when the connection is.
  std::string Hear() {
    for (std::string line; Readable();) {
      char c = 0;
      const ssize_t count = recv(socket_.Number(), &c, 1, 0);
      if (count <= 0) return count == 0 && line.empty() ? "closed" : "broken off after '" + line + "'";
      if (c == '\n') return line;
      line += c;
    }
    return "nothing";
  }
  void SayNoMore() {
    shutdown(socket_.Number(), SHUT_WR);
    AwaitArrival();
  }
  void Close() {
    SayNoMore();
    Disconnect();
  }
  /// The other side sees a connection that broke.
  void Break() {
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    setsockopt(socket_.Number(), SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
    Disconnect();
  }

 private:
  void Disconnect() { socket_ = Descriptor(); }
  void AwaitArrival() const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kHang_s);
    int unacknowledged = 1;  // bytes, the end counts as one
    while (ioctl(socket_.Number(), SIOCOUTQ, &unacknowledged) == 0 && unacknowledged > 0) {
      ASSERT_LT(std::chrono::steady_clock::now(), end);
      poll(nullptr, 0, 1);
    }
  }
  [[nodiscard]] bool Readable() const {
    pollfd wanted{.fd = socket_.Number(), .events = POLLIN, .revents = 0};
    return poll(&wanted, 1, static_cast<int>(kHang_s * 1000)) > 0;
  }
  Descriptor socket_;
  bool connected_ = false;
};

inline std::string Pose(const std::string& id, double x_m = 0.5) {
  return fmt::format("pose {} {} -0.25 1.5 0.6 0 0.8 0\n", id, x_m);
}

}  // namespace rigcal
