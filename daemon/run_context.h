#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "config/run_report.h"
#include "core/base/execution.h"

namespace rigcal {

/// Where a run stands, for people: "round 2 of 4: matching, 60 %".
struct RunProgress {
  std::string stage;
  int round = -1;  ///< from 0; -1 outside the rounds
  int num_rounds = 0;
  double stage_share = 0;           ///< [0, 1]
  std::optional<double> run_share;  ///< [0, 1], over all stages; nothing for a job without rounds
};

/// The number of threads that 0 stands for, or the number itself.
int NumThreads(int wanted);

/// How a run runs, as opposed to what it computes: threads, the stop token, the clock and who listens.
class RunContext {
 public:
  /// `now_s` is the run's clock (seconds, any origin); `listener` may be empty.
  RunContext(std::stop_token stop, int num_threads, std::function<double()> now_s,
             std::function<void(const RunProgress&)> listener);

  void SetNumRounds(int num_rounds) { num_rounds_ = num_rounds; }

  /// Runs one stage and writes down how long it took: `auto patches = context.Time("stereo", round, [&](const
  /// Execution& e) { return Reconstruct(..., e); })`.
  template <typename Stage>
  auto Time(const std::string& name, int round, const Stage& stage) {
    const Execution execution = Begin(name, round);
    const double begin_s = now_s_();
    auto result = stage(execution);
    timing_.stages.push_back({name, round, now_s_() - begin_s});
    return result;
  }

  /// The times so far; total since construction.
  [[nodiscard]] RunTiming Timing() const;

 private:
  Execution Begin(const std::string& name, int round);

  std::stop_token stop_;
  int num_threads_;
  std::function<double()> now_s_;
  std::function<void(const RunProgress&)> listener_;
  double begin_s_;
  int num_rounds_ = 0;
  RunTiming timing_;
};

}  // namespace rigcal
