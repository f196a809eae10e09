#pragma once

#include <optional>
#include <string>

namespace rigcal {

inline constexpr int kMostPort = 65535;
inline constexpr int kAnyPort = 0;  ///< of an address to listen on: one that is free

/// HOST:PORT in two parts; an IPv6 address is written in brackets, "[::1]:5100", and has none here.
struct SocketAddress {
  std::string host;
  int port = kAnyPort;
};

/// Nothing when the text is not HOST:PORT with a port from least_port to kMostPort.
std::optional<SocketAddress> ParseSocketAddress(const std::string& text, int least_port);

/// As ParseSocketAddress reads it.
std::string ToText(const SocketAddress& address);

}  // namespace rigcal
