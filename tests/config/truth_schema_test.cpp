#include <gtest/gtest.h>

#include "sim_fixtures/truth_file.h"
#include "tests/config/schema_check.h"

namespace rigcal {
namespace {

TEST(TruthFile, FollowsItsSchema) {
  sim::StudioOptions options;
  options.num_stops = 3;
  options.cell_m = 0.006;  // coarse: the surface does not matter here
  const auto studio = sim::MakeStudio(options, {});
  ASSERT_TRUE(studio) << studio.error().message;
  EXPECT_EQ(SchemaComplaints("truth.schema.json", sim::TruthText(*studio, {})), "");
}

TEST(TruthFile, OfAChartFollowsItsSchema) {
  sim::StudioOptions options;
  options.num_stops = 3;
  options.cell_m = 0.006;
  options.wobble_deg = 0.02;
  options.run_out_mm = 0.01;
  options.bumps = {{0, 0.5}};
  options.slips = {{1, 0.5}};
  sim::ChartOptions& chart = options.chart.emplace();
  chart.num_hand_held = 1;
  chart.print.board.columns = chart.print.board.rows = 1;
  chart.print.board.tag_m = 0.1;
  chart.print.board.gap_m = 0.03;
  chart.print.edge_cells = 8;
  chart.print.cells.emplace_back(10, 10, uchar{0});
  const auto studio = sim::MakeStudio(options, {});
  ASSERT_TRUE(studio) << studio.error().message;
  EXPECT_EQ(SchemaComplaints("truth.schema.json", sim::TruthText(*studio, {})), "");
}

}  // namespace
}  // namespace rigcal
