#pragma once

#include <optional>

#include "core/base/result.h"
#include "core/base/socket_address.h"
#include "drivers/line_connection.h"

namespace rigcal {

/// A TCP port that programs connect to.
class Listener {
 public:
  /// The host is an address of this machine in numbers, or "localhost"; port 0 takes one that is free. Errors: kDevice:
  /// the address is none, not of this machine, or in use.
  static Result<Listener> Open(const SocketAddress& address);

  /// With the port that it got.
  [[nodiscard]] const SocketAddress& Address() const { return address_; }

  /// The next program that has connected; never waits.
  std::optional<LineConnection> Accept();

 private:
  Listener(Descriptor socket, SocketAddress address) : socket_(std::move(socket)), address_(std::move(address)) {}

  Descriptor socket_;  ///< does not block
  SocketAddress address_;
};

}  // namespace rigcal
