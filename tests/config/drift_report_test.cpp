#include "config/drift_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/config/schema_check.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

DriftReport ExampleReport() {
  DriftReport report{.recording_id = "night-1", .recorded_at = "2026-01-02T03:00:00Z", .calibration_sha256 = "abc"};
  DriftFinding& finding = report.finding;
  finding.state = DriftState::kDrifting;
  finding.limit_px = 0.15;
  finding.suspects = {"left"};
  finding.which_is_told = true;
  finding.sentences = {"drifting: camera left moved"};
  finding.reasons = {{"motion", 0.31, 0.15, "px", "left"}, {"slipped stops", 1, 0, "", std::nullopt}};
  CameraDrift left{.camera = "left", .chi_square = 200, .moved = true};
  left.motion = {.moved_px = 0.31, .sigma_px = 0.03, .shift_px = {0.3, -0.4}, .shift_sigma_px = {0.02, 0.03}};
  left.evidence = {.num_features = 1200, .before_px = 0.2, .after_px = 0.1};
  finding.cameras = {left, {.camera = "right"}};
  finding.together = CameraDrift{};
  report.trend = {{.camera = "left", .num_nights = 3, .px_per_day = {0.01, 0}, .sigma_px_per_day = {0.005, 0.005}}};
  report.notes = {"a note"};
  return report;
}

DriftReport Night(const std::string& id, const std::string& time, const std::string& calibration, double shift_px) {
  DriftReport report = ExampleReport();
  report.recording_id = id, report.recorded_at = time, report.calibration_sha256 = calibration;
  report.finding.cameras[0].motion.shift_px = {shift_px, 0};
  return report;
}

EarlierNight Reread(const DriftReport& report) {
  const auto earlier = ParseEarlierNight(DriftText(report), "drift.json");
  EXPECT_TRUE(earlier) << (earlier ? "" : earlier.error().message);
  return earlier.value_or(EarlierNight{});
}

TEST(DriftText, FollowsItsSchema) {
  EXPECT_EQ(SchemaComplaints("drift.schema.json", DriftText(ExampleReport())), "");
  DriftReport least;
  least.finding.sentences = {"inconclusive: nothing was seen"};
  EXPECT_EQ(SchemaComplaints("drift.schema.json", DriftText(least)), "");
}

TEST(DriftText, SaysWhatItWasGiven) {
  const std::string text = DriftText(ExampleReport());
  EXPECT_THAT(text, HasSubstr("\"state\": \"drifting\""));
  EXPECT_THAT(text, HasSubstr("\"shift_px\": [0.3, -0.4]"));
  EXPECT_THAT(text, HasSubstr("\"direction\": [0.6, -0.8]"));
  EXPECT_THAT(text, HasSubstr("\"which_is_told\": true"));
  EXPECT_THAT(text, HasSubstr("\"before_px\": 0.2"));
}

TEST(DriftText, NumbersThatDoNotExistAreNull) {
  DriftReport report = ExampleReport();
  report.finding.cameras[0].motion.sigma_px = std::numeric_limits<double>::infinity();
  report.finding.cameras[0].motion.shift_px.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(SchemaComplaints("drift.schema.json", DriftText(report)), "");
  // Such a shift is no measurement for a trend; the other camera's is.
  ASSERT_TRUE(Reread(report).night);
  EXPECT_EQ(Reread(report).night->cameras.size(), 1U);
}

TEST(ParseEarlierNight, ReadsBackWhatATrendNeeds) {
  const EarlierNight night = Reread(ExampleReport());
  EXPECT_EQ(night.recording_id, "night-1");
  EXPECT_EQ(night.calibration_sha256, "abc");
  ASSERT_TRUE(night.night);
  EXPECT_NEAR(night.night->time_days, 20455.125, 1e-9);  // days from 1970 to the 2nd of January 2026, 03:00
  ASSERT_EQ(night.night->cameras.size(), 2U);
  EXPECT_EQ(night.night->cameras[0].shift_px, Eigen::Vector2d(0.3, -0.4));
  EXPECT_EQ(night.night->cameras[0].sigma_px, Eigen::Vector2d(0.02, 0.03));
}

TEST(ParseEarlierNight, RefusesWhatIsNoDriftCheck) {
  for (const char* text :
       {"{", "{}", R"({"format": "rigcal report", "version": 1})", R"({"format": "rigcal drift", "version": 2})",
        R"({"format": "rigcal drift", "version": 1})"}) {
    const auto night = ParseEarlierNight(text, "old/drift.json");
    ASSERT_FALSE(night) << text;
    EXPECT_THAT(night.error().message, HasSubstr("old/drift.json"));
  }
}

TEST(NightsWith, CountsEachRecordingOnceAndOneCalibrationOnly) {
  const DriftReport tonight = Night("n3", "2026-01-03T03:00:00Z", "abc", 0.3);
  DriftReport undated = Night("n9", "", "abc", 9);
  undated.recorded_at.reset();
  const std::vector<EarlierNight> earlier = {
      Reread(Night("n1", "2026-01-01T03:00:00Z", "abc", 0.1)), Reread(Night("n1", "2026-01-01T03:00:00Z", "abc", 0.1)),
      Reread(Night("n2", "2026-01-02T03:00:00Z", "another", 7)), Reread(undated), Reread(tonight)};
  const auto nights = NightsWith(tonight, earlier);
  ASSERT_EQ(nights.size(), 2U);
  const auto trend = TrendOf(nights);
  ASSERT_EQ(trend.size(), 1U);  // "right" states no sigma
  EXPECT_EQ(trend[0].camera, "left");
  EXPECT_NEAR(trend[0].px_per_day.x(), 0.1, 1e-9);
  DriftReport no_time = tonight;
  no_time.recorded_at.reset();
  EXPECT_TRUE(NightsWith(no_time, earlier).empty());
}

}  // namespace
}  // namespace rigcal
