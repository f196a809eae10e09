#include "drivers/line_connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>

namespace rigcal {
namespace {

constexpr std::size_t kChunk_bytes = 1024;
constexpr std::size_t kMostReceived_bytes = 4096;  ///< several lines; a peer that floods does not fill the memory
constexpr int kMostDrained = 64;                   ///< chunks: more than a system keeps for a connection by default

}  // namespace

std::string OnOneLine(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, ' ');
  return text;
}

LineConnection::~LineConnection() {
  if (socket_.Number() < 0) return;
  // Closing with something unread would throw away what was sent last, and with it the reason.
  shutdown(socket_.Number(), SHUT_WR);
  std::array<char, kChunk_bytes> chunk{};
  for (int i = 0; i < kMostDrained && recv(socket_.Number(), chunk.data(), chunk.size(), 0) > 0; ++i) {
  }
}

void LineConnection::Await(int milliseconds) const {
  pollfd waited{.fd = socket_.Number(), .events = POLLIN, .revents = 0};
  poll(&waited, 1, milliseconds);
}

void LineConnection::Receive() {
  std::array<char, kChunk_bytes> chunk{};
  while (!closed_ && !lost_ && received_.size() < kMostReceived_bytes) {
    const ssize_t count = recv(socket_.Number(), chunk.data(), chunk.size(), 0);
    if (count > 0) received_.append(chunk.data(), static_cast<std::size_t>(count));
    if (count == 0) closed_ = true;
    if (count >= 0 || errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK) lost_ = true;
    return;
  }
}

std::optional<std::string> LineConnection::TakeLine() {
  received_.erase(0, received_.find_first_not_of("\r\n"));
  const std::size_t end = received_.find('\n');
  if (end == std::string::npos && received_.size() <= kLongestLine_bytes + 1) return std::nullopt;  // 1: a '\r'
  std::string line = received_.substr(0, end);
  received_.erase(0, end == std::string::npos ? end : end + 1);
  if (line.ends_with('\r')) line.pop_back();
  return line;
}

std::string_view LineConnection::Begun() const {
  std::string_view line = received_;
  line.remove_prefix(std::min(line.find_first_not_of("\r\n"), line.size()));
  line = line.substr(0, line.find('\n'));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

bool LineConnection::Send(std::string line) {
  line = OnOneLine(std::move(line)) + "\n";
  if (lost_) return false;
  const ssize_t sent = send(socket_.Number(), line.data(), line.size(), MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(line.size())) lost_ = true;
  return !lost_;
}

}  // namespace rigcal
