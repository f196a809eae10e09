#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/descriptor.h"

namespace rigcal {

/// How long a line may be, its end not counted: an arm's pose with all its digits needs less than 200, LinuxCNC's
/// messages 255.
inline constexpr int kLongestLine_bytes = 512;

/// The text on one line, without characters that would end it.
std::string OnOneLine(std::string text);

/// A TCP connection that carries lines of text and never waits: what has come is taken, what does not go at once is a
/// lost connection.
class LineConnection {
 public:
  /// `peer` is its address for messages.
  LineConnection(Descriptor socket, std::string peer) : socket_(std::move(socket)), peer_(std::move(peer)) {}
  LineConnection(LineConnection&&) = default;
  LineConnection& operator=(LineConnection&&) = default;
  ~LineConnection();

  /// Waits until something has come, or the connection has ended, at most so long.
  void Await(int milliseconds) const;
  /// Takes in what has come; more than a few lines are left to the system.
  void Receive();
  /// The next whole line without its end ("\n" or "\r\n"), or the begin of one that is too long. Empty ones are
  /// passed over.
  std::optional<std::string> TakeLine();
  /// What has come of the next line that is not empty, without its end; empty: nothing.
  [[nodiscard]] std::string_view Begun() const;

  /// The peer says nothing more, in good order; what it said before may still wait to be taken.
  [[nodiscard]] bool Closed() const { return closed_; }
  /// The connection broke.
  [[nodiscard]] bool Lost() const { return lost_; }

  /// Sends the line, newlines in it taken out; false when the connection is lost.
  bool Send(std::string line);

  [[nodiscard]] const std::string& Peer() const { return peer_; }

 private:
  Descriptor socket_;  ///< does not block
  std::string peer_, received_;
  bool closed_ = false, lost_ = false;
};

}  // namespace rigcal
