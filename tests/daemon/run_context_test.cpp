#include "daemon/run_context.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(RunContext, TheShareOfARunNeverFalls) {
  std::vector<RunProgress> seen;
  RunContext context(
      {}, 1, [] { return 0.0; }, [&](const RunProgress& progress) { seen.push_back(progress); });
  context.SetNumRounds(2);
  const auto stage = [](const Execution& execution) {
    for (const double share : {0.0, 0.5, 1.0}) execution.Report(share);
    return 0;
  };
  for (const char* name : {"load", "estimate", "sparse", "approach"}) context.Time(name, -1, stage);
  for (const int round : {0, 1}) {
    for (const char* name : {"stereo", "match", "adjust"}) context.Time(name, round, stage);
  }
  for (const char* name : {"validate", "write"}) context.Time(name, -1, stage);
  double last = 0;
  for (const RunProgress& progress : seen) {
    ASSERT_TRUE(progress.run_share) << progress.stage;
    EXPECT_GE(*progress.run_share, last) << progress.stage;
    last = *progress.run_share;
  }
  EXPECT_EQ(last, 1);
}

TEST(RunContext, AJobWithoutRoundsTellsTheStageAlone) {
  RunProgress last;
  RunContext context(
      {}, 1, [] { return 0.0; }, [&](const RunProgress& progress) { last = progress; });
  context.Time("detect", -1, [](const Execution& execution) {
    execution.Report(0.5);
    return 0;
  });
  EXPECT_FALSE(last.run_share);
  EXPECT_EQ(last.stage_share, 0.5);
}

}  // namespace
}  // namespace rigcal
