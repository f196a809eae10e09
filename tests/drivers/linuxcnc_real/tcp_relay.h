#pragma once

#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/descriptor.h"

namespace rigcal {

/// Passes TCP connections to a port of 127.0.0.1 on, and can cut them: the cable between rigcal and a controller.
class TcpRelay {
 public:
  explicit TcpRelay(int target_port);
  ~TcpRelay();

  /// "127.0.0.1:PORT"
  [[nodiscard]] const std::string& Address() const { return address_; }
  /// Ends all connections; new ones are passed on again.
  void Cut();

 private:
  void Serve(const std::stop_token& stop);

  int target_port_;
  Descriptor listener_;
  std::string address_;
  std::mutex mutex_;
  std::vector<std::pair<Descriptor, Descriptor>> pairs_;
  std::jthread thread_;  ///< last: it uses all of the above
};

}  // namespace rigcal
