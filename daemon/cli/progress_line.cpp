#include "daemon/cli/progress_line.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "core/base/clock.h"

namespace rigcal {
namespace {

constexpr double kRedrawAfterS = 0.1;  ///< a person reads no faster

}  // namespace

ProgressLine::ProgressLine(bool on_terminal, std::function<double()> now_s)
    : on_terminal_(on_terminal), now_s_(std::move(now_s)), begin_s_(now_s_()), shown_s_(begin_s_ - kRedrawAfterS) {}

ProgressLine::~ProgressLine() {
  Clear();
}

void ProgressLine::Show(const RunProgress& progress) {
  if (!on_terminal_) return;
  const std::lock_guard lock(mutex_);
  const double now_s = now_s_();
  if (now_s - shown_s_ < kRedrawAfterS) return;
  shown_s_ = now_s;
  visible_ = true;
  fmt::print(stderr, "\r\x1b[K{}", ProgressText({progress, TimeLeftS(progress, now_s - begin_s_)}));
  std::fflush(stderr);
}

void ProgressLine::Clear() {
  const std::lock_guard lock(mutex_);
  if (!visible_) return;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
  visible_ = false;
}

double MonotonicSeconds() {
  return SystemClock().NowS();
}

}  // namespace rigcal
