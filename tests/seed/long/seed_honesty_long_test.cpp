#include <gtest/gtest.h>

#include <algorithm>

#include "tests/seed/seed_honesty.h"

namespace rigcal {
namespace {

using namespace synthetic;

void ExpectHonest(const char* name, const std::vector<double>& normalised) {
  const Moments moments = MomentsOf(normalised);
  testing::Test::RecordProperty(std::string(name) + "_mean", std::to_string(moments.mean));
  testing::Test::RecordProperty(std::string(name) + "_deviation", std::to_string(moments.deviation));
  EXPECT_LT(std::abs(moments.mean), 0.3) << name;
  EXPECT_GT(moments.deviation, 0.8) << name;
  EXPECT_LT(moments.deviation, 1.25) << name;
}

/// Issue 3: with the truth redrawn from the priors 100 times, the stated uncertainty is honest.
TEST(SeedOf100Truths, StatesItsUncertaintyHonestly) {
  constexpr int kRuns = 100;
  StudioOptions options;
  options.large_board = true;
  options.draw_shape = true;
  Normalised normalised;
  std::vector<double> direction_deg, point_mm, direction_sigma_deg, point_sigma_mm, focal_percent;
  std::vector<double> turned_on_board_deg, direction_on_board_deg, point_on_board_mm;
  for (int run = 0; run < kRuns; ++run) {
    const Studio studio = TurntableStudio(DeriveSeed(3, static_cast<std::uint64_t>(run)), options);
    const Result<SeedResult> result = SeedCameras(studio.scene, {}, {});
    ASSERT_TRUE(result) << result.error().message;
    normalised.Collect(studio, *result);
    const AxisError axis = AxisErrorOf(studio, *result);
    direction_deg.push_back(axis.direction_rad / kDegree);
    point_mm.push_back(1e3 * axis.point_m);
    turned_on_board_deg.push_back(axis.turned_on_board_rad / kDegree);
    direction_on_board_deg.push_back(axis.direction_on_board_rad / kDegree);
    point_on_board_mm.push_back(1e3 * axis.point_on_board_m);
    direction_sigma_deg.push_back(result->rig->axis->direction_sigma_rad / kDegree);
    point_sigma_mm.push_back(1e3 * result->rig->axis->point_sigma_m);
    for (std::size_t c = 0; c < studio.truth.cameras.size(); ++c) {
      const double ratio = result->calibration.cameras[c].fx_px / studio.truth.cameras[c].fx_px;
      focal_percent.push_back(100 * std::abs(ratio - 1));
    }
  }
  ExpectHonest("intrinsics", normalised.intrinsics);
  ExpectHonest("poses", normalised.poses);
  ExpectHonest("axis", normalised.axis);
  ExpectHonest("stop_errors", normalised.stop_errors);
  ExpectHonest("board", normalised.board);
  ExpectHonest("hand_held", normalised.hand_held);
  const auto record = [](const char* name, std::vector<double> values) {
    std::sort(values.begin(), values.end());
    testing::Test::RecordProperty(std::string(name) + "_median", std::to_string(values[values.size() / 2]));
    testing::Test::RecordProperty(std::string(name) + "_worst", std::to_string(values.back()));
    return values.back();
  };
  EXPECT_LT(record("focal_percent", focal_percent), 0.05);
  record("axis_direction_deg", direction_deg);
  record("axis_point_mm", point_mm);
  record("axis_direction_on_board_deg", direction_on_board_deg);
  EXPECT_LT(record("axis_turned_on_board_deg", turned_on_board_deg), 0.01);
  EXPECT_LT(record("axis_point_on_board_mm", point_on_board_mm), 0.02);
  record("axis_direction_sigma_deg", direction_sigma_deg);
  record("axis_point_sigma_mm", point_sigma_mm);
}

}  // namespace
}  // namespace rigcal
