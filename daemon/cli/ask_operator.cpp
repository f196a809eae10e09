#include "daemon/cli/ask_operator.h"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <string_view>

#include "core/base/clock.h"

namespace rigcal {
namespace {

constexpr int kPoll_ms = 100;  ///< how soon a stop token is seen

}  // namespace

bool OperatorIsThere() {
  return isatty(STDIN_FILENO) != 0;
}

Result<void> AskOperator(const std::string& what, double timeout_s, const std::stop_token& stop) {
  tcflush(STDIN_FILENO, TCIFLUSH);
  fmt::print(stderr, "\n{}, then press Enter\n", what);
  const SystemClock clock;
  const double end_s = clock.NowS() + timeout_s;
  while (!stop.stop_requested()) {
    pollfd terminal{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    std::array<char, 64> typed{};
    const bool ready = poll(&terminal, 1, kPoll_ms) > 0;
    const ssize_t count = ready ? read(STDIN_FILENO, typed.data(), typed.size()) : 0;
    if (ready && count <= 0) return Fail(ErrorCode::kDevice, "{}: the terminal is gone", what);
    if (std::string_view(typed.data(), static_cast<std::size_t>(count)).find('\n') != std::string_view::npos) return {};
    if (clock.NowS() >= end_s) {
      return Fail(ErrorCode::kTimeout, "{}: Enter was not pressed within {:.1f} s", what, timeout_s);
    }
  }
  return Fail(ErrorCode::kCancelled, "{}: waiting for it was stopped on request", what);
}

}  // namespace rigcal
