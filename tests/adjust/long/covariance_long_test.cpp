#include <gtest/gtest.h>

#include "tests/adjust/covariance_honesty.h"

namespace rigcal {
namespace {

using namespace synthetic;

void ExpectHonest(const Honesty& honesty) {
  testing::Test::RecordProperty("mean", std::to_string(honesty.mean));
  testing::Test::RecordProperty("deviation", std::to_string(honesty.deviation));
  EXPECT_LT(std::abs(honesty.mean), 0.3);
  EXPECT_GT(honesty.deviation, 0.8);
  EXPECT_LT(honesty.deviation, 1.25);
  EXPECT_GT(honesty.true_px / honesty.stated_px, 0.7);
  EXPECT_LT(honesty.true_px / honesty.stated_px, 1.1);
}

TEST(CovarianceOf100Truths, RingFromSixPixels) {
  ExpectHonest(RedrawTruth(Ring(14), 6, 500, 100));
}

TEST(CovarianceOf100Truths, HemisphereFromSixPixels) {
  ExpectHonest(RedrawTruth(Hemisphere(14), 6, 500, 100));
}

}  // namespace
}  // namespace rigcal
