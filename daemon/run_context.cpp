#include "daemon/run_context.h"

#include <array>
#include <string_view>
#include <utility>

namespace rigcal {
namespace {

/// Share of a round that each stage takes (measured on templeSparseRing; only the progress line depends on it).
struct StageShare {
  std::string_view stage;
  double begin;
  double length;
};
constexpr std::array<StageShare, 4> kStageShares = {
    {{"stereo", 0.0, 0.45}, {"sparse", 0.45, 0.1}, {"match", 0.55, 0.2}, {"adjust", 0.75, 0.25}}};
constexpr double kShareBeforeRounds = 0.1;  ///< loading and the estimate of Er
constexpr double kShareAfterRounds = 0.05;  ///< validation and writing

double RunShare(const RunProgress& p) {
  if (p.round < 0 || p.num_rounds == 0) {
    return p.stage == "validate" ? 1 - kShareAfterRounds * (1 - p.stage_share) : kShareBeforeRounds * p.stage_share;
  }
  double in_round = 0;
  for (const StageShare& s : kStageShares) {
    if (s.stage == p.stage) in_round = s.begin + s.length * p.stage_share;
  }
  const double rounds = 1 - kShareBeforeRounds - kShareAfterRounds;
  return kShareBeforeRounds + rounds * (p.round + in_round) / p.num_rounds;
}

}  // namespace

RunContext::RunContext(std::stop_token stop, int num_threads, std::function<double()> now_s,
                       std::function<void(const RunProgress&)> listener)
    : stop_(std::move(stop)),
      num_threads_(num_threads),
      now_s_(std::move(now_s)),
      listener_(std::move(listener)),
      begin_s_(now_s_()) {}

RunTiming RunContext::Timing() const {
  RunTiming timing = timing_;
  timing.total_wall_s = now_s_() - begin_s_;
  return timing;
}

Execution RunContext::Begin(const std::string& name, int round) {
  Execution execution{.stop = stop_, .num_threads = num_threads_};
  if (listener_) {
    execution.report_progress = [this, name, round](double share) {
      RunProgress progress{.stage = name, .round = round, .num_rounds = num_rounds_, .stage_share = share};
      progress.run_share = RunShare(progress);
      listener_(progress);
    };
    execution.report_progress(0);
  }
  return execution;
}

}  // namespace rigcal
