#pragma once

#include <functional>
#include <mutex>
#include <string>

#include "daemon/run_context.h"

namespace rigcal {

/// One line on a terminal that is written over as a run goes on: stage, round, share done, time left. Silent when
/// stderr is not a terminal.
class ProgressLine {
 public:
  ProgressLine(bool on_terminal, std::function<double()> now_s);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void Show(const RunProgress& progress);
  /// Removes the line, so that what is printed next stands alone.
  void Clear();

 private:
  bool on_terminal_;
  std::function<double()> now_s_;
  double begin_s_;
  double shown_s_;
  bool visible_ = false;
  std::mutex mutex_;
};

/// "stereo, round 2 of 4: 37 %, about 12 s left": the text of the line; `elapsed_s` since the run began.
std::string ProgressText(const RunProgress& progress, double elapsed_s);

/// The wall clock that runs are timed with: seconds since an arbitrary origin, never going back.
double MonotonicSeconds();

}  // namespace rigcal
