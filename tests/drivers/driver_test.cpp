#include "drivers/driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kRadPerDeg = std::numbers::pi / 180;

std::string WhyNot(double angle_rad) {
  const std::vector<AxisSettings> axes = {{.name = "table", .least = -10 * kRadPerDeg, .most = 60 * kRadPerDeg}};
  const Result<void> checked = CheckTarget({"07", {angle_rad}}, axes, "a table");
  return checked ? "" : checked.error().message;
}

TEST(CheckTarget, AllowsWhatIsWithinTheSoftLimits) {
  for (const double angle_deg : {-10.0, 0.0, 60.0}) EXPECT_EQ(WhyNot(angle_deg * kRadPerDeg), "");
  const double counted_rad = 5 * (12 * kRadPerDeg), round_backlash_rad = 2 * kRadPerDeg - 12 * kRadPerDeg;
  EXPECT_GT(counted_rad, 60 * kRadPerDeg) << "the same angle, on another way";
  EXPECT_EQ(WhyNot(counted_rad), "");
  EXPECT_LT(round_backlash_rad, -10 * kRadPerDeg);
  EXPECT_EQ(WhyNot(round_backlash_rad), "");
}

TEST(CheckTarget, NamesWhatIsBeyond) {
  EXPECT_THAT(WhyNot(60.001 * kRadPerDeg), AllOf(HasSubstr("a table: stop '07': axis 'table'"), HasSubstr("1.047")));
  EXPECT_NE(WhyNot(-10.001 * kRadPerDeg), "");
}

}  // namespace
}  // namespace rigcal
