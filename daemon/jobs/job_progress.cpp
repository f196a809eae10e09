#include "daemon/jobs/job_progress.h"

#include <fmt/format.h>

namespace rigcal {
namespace {

constexpr double kEstimateFromShare = 0.05;  ///< before this share is done, the time left is a guess not worth showing

}  // namespace

std::optional<double> TimeLeftS(const RunProgress& progress, double elapsed_s) {
  const double done = progress.run_share.value_or(0);
  if (done < kEstimateFromShare) return std::nullopt;
  return elapsed_s * (1 - done) / done;
}

std::string ProgressText(const JobProgress& progress) {
  const RunProgress& run = progress.run;
  std::string text = run.stage;
  if (run.round >= 0) text += fmt::format(", round {} of {}", run.round + 1, run.num_rounds);
  text += fmt::format(": {:.0f} %", 100 * run.run_share.value_or(run.stage_share));
  if (progress.left_s) text += fmt::format(", about {:.0f} s left", *progress.left_s);
  return text;
}

}  // namespace rigcal
