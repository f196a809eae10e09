#include "config/run_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/config/example_rig.h"
#include "tests/config/schema_check.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

RunReport ExampleReport() {
  RunReport report;
  report.method = "rigcal";
  report.expected_error_px = 7;
  report.level = 2;
  report.validation.verdict = Verdict::kRejected;
  report.validation.reasons = {{"holdout", 1.5, 1, "px", std::nullopt}, {"support", 3, 100, "features", "ring_01.png"}};
  report.validation.holdout = {2.5, 0.4, 120};
  report.validation.views = {{"ring_00.png", "camera", 3.5, {0.6, -0.8}, 0.1, 250, 0.3}};
  report.rounds = {{2, 1000, 800, 4000, 0.7, 0.4, {7, 7, 4.5}, 1.5}};
  report.views_per_track = {0, 0, 500, 300};
  report.cameras = {{ExampleRing(3).cameras[0], IntrinsicVector::Constant(0.25)}};
  report.masks = {{"ring_00.png", "dark", 0.25}};
  report.notes = {"a note"};
  return report;
}

TEST(RunReport, FollowsItsSchema) {
  EXPECT_EQ(SchemaComplaints("report.schema.json", ReportText(ExampleReport())), "");
  EXPECT_EQ(SchemaComplaints("report.schema.json", ReportText({.method = "paper"})), "");
}

TEST(RunReport, SchemaNoticesAnUnknownVerdict) {
  std::string text = ReportText(ExampleReport());
  text.replace(text.find("rejected"), 8, "excluded");
  EXPECT_NE(SchemaComplaints("report.schema.json", text), "");
}

TEST(RunReport, SaysWhatItWasGiven) {
  const std::string text = ReportText(ExampleReport());
  EXPECT_THAT(text, HasSubstr("\"verdict\": \"rejected\""));
  EXPECT_THAT(text, HasSubstr("\"view\": \"ring_01.png\""));
  EXPECT_THAT(text, HasSubstr("\"direction\": [0.6, -0.8]"));
  EXPECT_THAT(text, HasSubstr("\"expected_error_px\": [7.0, 7.0, 4.5]"));
  EXPECT_THAT(text, HasSubstr("\"tracks\": 300"));
}

TEST(RunReport, NumbersThatDoNotExistAreNull) {
  RunReport report = ExampleReport();
  report.validation.holdout.before_px = std::numeric_limits<double>::quiet_NaN();
  report.validation.reasons[0].value = std::numeric_limits<double>::infinity();
  const std::string text = ReportText(report);
  EXPECT_THAT(text, HasSubstr("\"before_px\": null"));
  EXPECT_EQ(SchemaComplaints("report.schema.json", text), "");
  report.validation.holdout.before_px.reset();
  EXPECT_THAT(ReportText(report), HasSubstr("\"before_px\": null"));
}

TEST(RunTiming, FollowsItsSchema) {
  const RunTiming timing{{{"load", -1, 0.5}, {"stereo", 0, 2.25}}, 3};
  const std::string text = TimingText(timing);
  EXPECT_EQ(SchemaComplaints("timing.schema.json", text), "");
  EXPECT_THAT(text, HasSubstr("\"round\": 0"));
}

}  // namespace
}  // namespace rigcal
