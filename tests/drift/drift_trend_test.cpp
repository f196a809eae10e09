#include "core/drift/drift_trend.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rigcal {
namespace {

DriftNight Night(double time_days, const std::string& camera, const Eigen::Vector2d& shift_px,
                 const Eigen::Vector2d& sigma_px) {
  return {.time_days = time_days, .cameras = {{camera, shift_px, sigma_px}}};
}

TEST(TrendOf, FindsTheSlopeOfEachCameraAndItsSigma) {
  std::vector<DriftNight> nights;
  for (int day = 0; day < 5; ++day) {
    nights.push_back(Night(20000 + day, "left", {0.1 + 0.02 * day, -0.01 * day}, {0.05, 0.1}));
    nights.back().cameras.push_back({"right", {0.3, 0.3}, {0.05, 0.05}});
  }
  const auto trends = TrendOf(nights);
  ASSERT_EQ(trends.size(), 2U);
  EXPECT_EQ(trends[0].camera, "left");
  EXPECT_EQ(trends[0].num_nights, 5);
  EXPECT_NEAR(trends[0].px_per_day.x(), 0.02, 1e-9);
  EXPECT_NEAR(trends[0].px_per_day.y(), -0.01, 1e-9);
  // sigma over the root of the sum of squared times about their mean: 10
  EXPECT_NEAR(trends[0].sigma_px_per_day.x(), 0.05 / std::sqrt(10), 1e-9);
  EXPECT_NEAR(trends[0].sigma_px_per_day.y(), 0.1 / std::sqrt(10), 1e-9);
  EXPECT_EQ(trends[1].camera, "right");
  EXPECT_NEAR(trends[1].px_per_day.norm(), 0, 1e-9);
}

TEST(TrendOf, UncertainNightsCountLittle) {
  const std::vector<DriftNight> nights = {Night(0, "a", {0, 0}, {0.01, 0.01}), Night(1, "a", {0.1, 0}, {0.01, 0.01}),
                                          Night(2, "a", {9, 0}, {100, 0.01})};
  EXPECT_NEAR(TrendOf(nights)[0].px_per_day.x(), 0.1, 1e-3);
}

TEST(TrendOf, NeedsTwoTimesAndASigma) {
  EXPECT_TRUE(TrendOf({}).empty());
  EXPECT_TRUE(TrendOf({Night(1, "a", {1, 1}, {1, 1})}).empty());
  EXPECT_TRUE(TrendOf({Night(1, "a", {1, 1}, {1, 1}), Night(1, "a", {2, 1}, {1, 1})}).empty());
  EXPECT_TRUE(TrendOf({Night(1, "a", {1, 1}, {1, 0}), Night(2, "a", {2, 1}, {1, 1})}).empty());
  EXPECT_EQ(TrendOf({Night(1, "a", {1, 1}, {1, 1}), Night(2, "a", {2, 1}, {1, 1})}).size(), 1U);
}

}  // namespace
}  // namespace rigcal
