#pragma once

#include <functional>
#include <mutex>
#include <string>

#include "daemon/jobs/job_progress.h"

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

/// The wall clock that runs are timed with: seconds since an arbitrary origin, never going back.
double MonotonicSeconds();

}  // namespace rigcal
