#include "core/base/socket_address.h"

#include <fmt/format.h>

#include <charconv>

namespace rigcal {

std::optional<SocketAddress> ParseSocketAddress(const std::string& text, int least_port) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  SocketAddress address{.host = text.substr(0, colon)};
  const bool in_brackets = address.host.starts_with('[') && address.host.ends_with(']');
  if (in_brackets) address.host = address.host.substr(1, address.host.size() - 2);
  if (address.host.empty() || (address.host.find(':') != std::string::npos) != in_brackets) return std::nullopt;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data() + colon + 1, end, address.port);
  if (error != std::errc() || last != end || address.port < least_port || address.port > kMostPort) return std::nullopt;
  return address;
}

std::string ToText(const SocketAddress& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return v6 ? fmt::format("[{}]:{}", address.host, address.port) : fmt::format("{}:{}", address.host, address.port);
}

}  // namespace rigcal
