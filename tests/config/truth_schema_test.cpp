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

}  // namespace
}  // namespace rigcal
