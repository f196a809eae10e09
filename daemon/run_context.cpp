#include "daemon/run_context.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <thread>
#include <utility>

namespace rigcal {
namespace {

/// Where a stage lies in what it is part of (chosen: only the progress line depends on it).
struct StageShare {
  std::string_view stage;
  double begin;
  double length;
};
constexpr std::array<StageShare, 3> kOfRound = {{{"stereo", 0.0, 0.5}, {"match", 0.5, 0.25}, {"adjust", 0.75, 0.25}}};
constexpr double kShareBeforeRounds = 0.1, kShareAfterRounds = 0.05;
constexpr std::array<StageShare, 6> kOfRun = {{{"load", 0.0, 0.02},
                                               {"estimate", 0.02, 0.02},
                                               {"sparse", 0.04, 0.04},
                                               {"approach", 0.08, 0.02},
                                               {"validate", 1 - kShareAfterRounds, 0.04},
                                               {"write", 0.99, 0.01}}};

template <std::size_t kCount>
double ShareIn(const std::array<StageShare, kCount>& shares, const RunProgress& p) {
  for (const StageShare& s : shares) {
    if (s.stage == p.stage) return s.begin + s.length * p.stage_share;
  }
  return 0;
}

double RunShare(const RunProgress& p) {
  if (p.round < 0) return ShareIn(kOfRun, p);
  const double rounds = 1 - kShareBeforeRounds - kShareAfterRounds;
  return kShareBeforeRounds + rounds * (p.round + ShareIn(kOfRound, p)) / p.num_rounds;
}

}  // namespace

int NumThreads(int wanted) {
  return wanted > 0 ? wanted : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

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
      if (num_rounds_ > 0) progress.run_share = RunShare(progress);
      listener_(progress);
    };
    execution.report_progress(0);
  }
  return execution;
}

}  // namespace rigcal
