#include "config/rig_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/config/refusals.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;
constexpr const char* kTurntable =
    "[positioner]\nkind = \"turntable\"\nstep_sigma_deg = 0.03\nwobble_sigma_deg = 0.02\nrun_out_sigma_m = 1e-5\n";
constexpr const char* kGantry =
    "[positioner]\nkind = \"gantry\"\ncarries = \"cameras\"\naxes = [\"x\", \"z\"]\nposition_sigma_m = 2e-5\n";
constexpr const char* kArm = "[positioner]\nkind = \"arm\"\ncarries = \"object\"\nrotation_sigma_deg = 0.01\n";

void ExpectTextRefused(const std::string& text, const std::vector<std::string>& parts) {
  SCOPED_TRACE(text);
  ExpectRefused(ParseRig(text, "rig.toml"), parts);
}

TEST(RigFile, ReadsATurntable) {
  const Result<RigFile> rig = ParseRig(kTurntable, "rig.toml");
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->model.positioner.kind, PositionerKind::kTurntable);
  EXPECT_EQ(rig->axes, std::vector<std::string>{kTableAxis});
  StopError expected;
  expected << 0.02 * kDegree, 0.02 * kDegree, 0.03 * kDegree, 1e-5, 1e-5, 0;
  EXPECT_LT((rig->model.error_sigma - expected).norm(), 1e-15);
}

TEST(RigFile, ReadsAGantryAndAnArm) {
  const Result<RigFile> gantry = ParseRig(kGantry, "rig.toml"), arm = ParseRig(kArm, "rig.toml");
  ASSERT_TRUE(gantry) << gantry.error().message;
  EXPECT_EQ(gantry->model.positioner.load, PositionerLoad::kCameras);
  EXPECT_EQ(gantry->model.positioner.num_axes, 2);
  EXPECT_EQ(gantry->model.error_sigma[4], 2e-5);
  EXPECT_EQ(gantry->model.error_sigma[5], 0) << "there is no third axis";
  ASSERT_TRUE(arm) << arm.error().message;
  EXPECT_EQ(arm->model.positioner.load, PositionerLoad::kObject);
  EXPECT_NEAR(arm->model.error_sigma[2], 0.01 * kDegree, 1e-15);
  EXPECT_TRUE(arm->axes.empty());
}

TEST(RigFile, ReadsWhatItWrote) {
  for (const char* text : {kTurntable, kGantry, kArm}) {
    const Result<RigFile> rig = ParseRig(text, "rig.toml");
    ASSERT_TRUE(rig) << rig.error().message;
    const Result<RigFile> again = ParseRig(RigText(*rig), "again.toml");
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(again->axes, rig->axes);
    EXPECT_EQ(again->model.positioner.kind, rig->model.positioner.kind);
    EXPECT_EQ(again->model.positioner.load, rig->model.positioner.load);
    EXPECT_LT((again->model.error_sigma - rig->model.error_sigma).norm(), 1e-10 * rig->model.error_sigma.norm());
    EXPECT_EQ(again->model.axis_scale_sigma, rig->model.axis_scale_sigma);
  }
}

TEST(RigFile, NamesFileLineKeyAndRange) {
  ExpectTextRefused(Replaced(kTurntable, "0.03", "30"),
                    {"rig.toml line 3: step_sigma_deg", "30", "degrees from 0 to 10"});
  ExpectTextRefused(Replaced(kTurntable, "0.03", "\"0.03 deg\""), {"line 3: step_sigma_deg", "degrees"});
  ExpectTextRefused(Replaced(kTurntable, "step_sigma_deg", "step_sigma_rad"),
                    {"line 3: step_sigma_rad", "step_sigma_deg"});
  ExpectTextRefused(Replaced(kTurntable, "step_sigma_deg", "rotation_sigma_deg"), {"line 3", "turntable"});
  ExpectTextRefused(Replaced(kTurntable, "\"turntable\"", "\"carousel\""),
                    {"line 2: kind", "\"turntable\", \"gantry\""});
  ExpectTextRefused(Replaced(kTurntable, "kind = \"turntable\"\n", ""), {"positioner.kind is missing"});
  ExpectTextRefused(Replaced(kTurntable, "[positioner]", "[table]"), {"line 1: table", "positioner"});
  ExpectTextRefused("", {"[positioner] is missing"});
  ExpectTextRefused(std::string(kTurntable) + "carries = \"cameras\"\n", {"line 6: carries", "carries the object"});
  ExpectTextRefused(Replaced(kGantry, "carries = \"cameras\"\n", ""), {"positioner.carries is missing"});
  ExpectTextRefused(Replaced(kGantry, "[\"x\", \"z\"]", "[\"x\", \"x\"]"), {"line 4: axes", "different names"});
  ExpectTextRefused(Replaced(kGantry, "[\"x\", \"z\"]", "2"), {"line 4: axes", "one to three names"});
  ExpectTextRefused(std::string(kArm) + "axes = [\"x\"]\n", {"axes"});
}

Recording TurntableRecording() {
  Recording recording;
  recording.stops = {{"00", {{kTableAxis, AxisUnit::kRadian, 0.0, {}}}, {}, {}},
                     {"01", {{kTableAxis, AxisUnit::kRadian, 0.5, 0.51}}, {}, {}}};
  return recording;
}

TEST(StopPositions, AreThoseReportedElseThoseCommanded) {
  const auto stops = StopPositions(TurntableRecording(), *ParseRig(kTurntable, "rig.toml"), "REC");
  ASSERT_TRUE(stops) << stops.error().message;
  ASSERT_EQ(stops->size(), 2u);
  EXPECT_EQ((*stops)[0].axes, std::vector<double>{0.0});
  EXPECT_EQ((*stops)[1].axes, std::vector<double>{0.51});
}

TEST(StopPositions, NameTheStopThatDoesNotFitTheRig) {
  const RigFile turntable = *ParseRig(kTurntable, "rig.toml"), arm = *ParseRig(kArm, "rig.toml");
  Recording recording = TurntableRecording();
  EXPECT_THAT(StopPositions(recording, arm, "REC").error().message, HasSubstr("REC: stop '00' has no pose"));
  recording.stops[1].axes[0].unit = AxisUnit::kMetre;
  EXPECT_THAT(StopPositions(recording, turntable, "REC").error().message, HasSubstr("stop '01'"));
  recording.stops[1].axes[0].axis = "lift";
  EXPECT_THAT(StopPositions(recording, turntable, "REC").error().message, HasSubstr("axis 'table'"));
}

}  // namespace
}  // namespace rigcal
