#include <gtest/gtest.h>

#include "tests/adjust/covariance_honesty.h"

namespace rigcal {
namespace {

using namespace synthetic;

// The short form of tests/adjust/long: wide enough for 20 runs.
TEST(Covariance, StatesTheErrorsThatTruthsDrawnFromThePriorsShow) {
  const Honesty honesty = RedrawTruth(Hemisphere(12), 3, 200, 20);
  EXPECT_LT(std::abs(honesty.mean), 0.3);
  EXPECT_GT(honesty.deviation, 0.8);
  EXPECT_LT(honesty.deviation, 1.25);
  // TruthErrorPx is the mean of a length whose root mean square is stated: 0.89 of it for a round normal error.
  EXPECT_GT(honesty.true_px / honesty.stated_px, 0.7);
  EXPECT_LT(honesty.true_px / honesty.stated_px, 1.1);
}

}  // namespace
}  // namespace rigcal
