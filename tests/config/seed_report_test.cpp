#include "config/seed_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/config/schema_check.h"

namespace rigcal {
namespace {

SeedScene ExampleScene() {
  SeedScene scene;
  scene.cameras = {{"left", 640, 480}};
  scene.views = {{"a.png", 0, std::nullopt}, {"b.png", 0, std::nullopt}};
  return scene;
}

std::vector<ChartDetection> ExampleDetections() {
  std::vector<ChartDetection> detections(2);
  detections[0].num_tags = 1;
  detections[0].corners = {{.tag_id = 3, .corner = 1, .x_px = {10, 20}}};
  detections[1].findings = {{ChartFindingKind::kNothingSeen, "no tag of the board is seen", true}};
  return detections;
}

SeedResult ExampleSeed() {
  SeedResult seed;
  seed.calibration.cameras = {{.id = "left", .width_px = 640, .height_px = 480, .fx_px = 600, .fy_px = 601}};
  seed.report.cameras = {{.num_views = 1, .num_corners = 4, .rms_px = 0.2, .noise_scale = 1.5}};
  seed.report.view_rms_px = {0.2, 0};
  seed.report.advice = {"tilt the board"};
  return seed;
}

TEST(SeedReportText, FitsItsSchema) {
  EXPECT_EQ(
      SchemaComplaints("seed_report.schema.json", SeedReportText(ExampleScene(), ExampleDetections(), ExampleSeed())),
      "");
}

TEST(SeedReportText, SaysNullForWhatIsNotKnown) {
  SeedResult seed = ExampleSeed();
  seed.report.rms_px = std::nan("");
  const std::string text = SeedReportText(ExampleScene(), ExampleDetections(), seed);
  EXPECT_THAT(text, ::testing::HasSubstr("\"rms_px\": null"));
  EXPECT_EQ(SchemaComplaints("seed_report.schema.json", text), "");
}

TEST(SeedReportText, TellsTheAxisAndTheErrorsOfEachStop) {
  SeedScene scene = ExampleScene();
  scene.stops = {{.id = "00", .axes = {0}}, {.id = "01", .axes = {0.5}}};
  SeedResult seed = ExampleSeed();
  seed.rig = RigFit{.positioner = Turntable().positioner, .stop_ids = {"00", "01"}};
  seed.rig->axis = AxisEstimate{.camera = 0, .direction_sigma_rad = 1e-4, .point_sigma_m = 2e-5};
  seed.axis_on_board = AxisOnBoard{.point_in_board = {0.04, -0.03}, .direction_sigma_rad = 1e-4, .point_sigma_m = 3e-6};
  seed.rig->stop_errors.assign(2, StopError::Zero());
  seed.rig->stop_error_sigma.assign(2, StopError::Constant(1e-4));
  seed.rig->stop_errors[1][kStep] = 0.01;
  const std::string text = SeedReportText(scene, ExampleDetections(), seed);
  EXPECT_EQ(SchemaComplaints("seed_report.schema.json", text), "");
  const auto json = nlohmann::json::parse(text);
  const auto step = json.at("rig").at("stops").at(1).at("errors").at(kStep);
  EXPECT_EQ(step.at("name"), "step error");
  EXPECT_NEAR(step.at("value").get<double>(), 0.572958, 1e-6);  // degrees
  EXPECT_NEAR(json.at("rig").at("axis_on_board").at("direction_sigma_deg").get<double>(), 0.0057296, 1e-6);
  EXPECT_THAT(SeedSummaryText(scene, seed), ::testing::HasSubstr("axis in camera left"));
  EXPECT_THAT(SeedSummaryText(scene, seed), ::testing::HasSubstr("through (40.000, -30.000) +- 0.0030 mm"));
}

TEST(SeedSummaryText, SaysWhatToShowNext) {
  EXPECT_THAT(SeedSummaryText(ExampleScene(), ExampleSeed()), ::testing::HasSubstr("tilt the board"));
}

}  // namespace
}  // namespace rigcal
