#include "config/rig_stops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "config/rig_file.h"
#include "tests/config/example_rig_file.h"
#include "tests/config/refusals.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;

/// The stops of a turntable with limits of -90 and 360 degrees, in degrees.
Result<std::vector<double>> Angles(const std::string& stops, const std::string& axis = "") {
  const std::string text =
      "[positioner]\nkind = \"turntable\"\n[[positioner.axis]]\nlimits_deg = [-90, 360]\n" + axis + "[stops]\n" + stops;
  const Result<RigFile> rig = ParseRig(text, "rig.toml");
  if (!rig) return Fail(rig.error());
  std::vector<double> angles_deg;
  for (const std::vector<double>& stop : rig->capture.stops) {
    EXPECT_EQ(stop.size(), 1u);
    angles_deg.push_back(stop[0] * 180 / std::numbers::pi);
  }
  return angles_deg;
}

std::string WhyNot(const std::string& stops, const std::string& axis = "") {
  return Message(Angles(stops, axis));
}

void ExpectAngles(const std::string& stops, const std::vector<double>& expected_deg) {
  SCOPED_TRACE(stops);
  const auto angles = Angles(stops);
  ASSERT_TRUE(angles) << Message(angles);
  ASSERT_EQ(angles->size(), expected_deg.size());
  for (std::size_t s = 0; s < expected_deg.size(); ++s) EXPECT_NEAR((*angles)[s], expected_deg[s], 1e-9);
}

TEST(RigStops, ATurntablesAreListedOrCounted) {
  ExpectAngles("angles_deg = [0, 10, -90, 350]\n", {0, 10, -90, 350});
  ExpectAngles("count = 4\n", {0, 90, 180, 270});
  ExpectAngles("start_deg = 5\nstep_deg = -10\ncount = 3\n", {5, -5, -15});
}

TEST(RigStops, AGantrysAreListsOfPositions) {
  const Result<RigFile> rig = ParseRig(kGantryRig, "rig.toml");
  ASSERT_TRUE(rig) << Message(rig);
  EXPECT_THAT(rig->capture.stops, ElementsAre(ElementsAre(0, 0.1), ElementsAre(0.2, 0.1)));
}

TEST(RigStops, AreRefusedBeyondTheSoftLimits) {
  EXPECT_EQ(WhyNot("angles_deg = [0, 361]\n"),
            "rig.toml line 6: angles_deg: stop 2 at 361 degrees is outside the soft limits of the axis 'table', "
            "-90 degrees to 360 degrees");
  EXPECT_EQ(WhyNot("count = 12\nstart_deg = 60\n"),
            "rig.toml line 6: count: stop 12 at 390 degrees is outside the soft limits of the axis 'table', "
            "-90 degrees to 360 degrees");
  const std::string backlash = "approach = \"up\"\nbacklash_deg = 3\n";
  EXPECT_EQ(WhyNot("angles_deg = [-88]\n", backlash),
            "rig.toml line 8: angles_deg: stop 1 at -88 degrees is outside the soft limits of the axis 'table', "
            "-90 degrees to 360 degrees, on the way round its backlash");
  EXPECT_EQ(WhyNot("angles_deg = [-87, 360]\n", backlash), kNoError);
  EXPECT_EQ(WhyNot("count = 5\nstart_deg = 6\nstep_deg = -24\n"), kNoError) << "-90 degrees but for rounding";
  EXPECT_NE(WhyNot("angles_deg = [360.0001]\n"), kNoError) << "what a device refuses in the middle of a capture";
  ExpectRefused(ParseRig(Replaced(kGantryRig, "[0.2, 0.1]", "[0.2, 0.499]"), "rig.toml"),
                {"line 14: positions_m: stop 2 at 0.499 metres", "axis 'z'", "backlash"});
}

TEST(RigStops, AreRefusedTwice) {
  EXPECT_EQ(WhyNot("angles_deg = [0, 10, 360]\n"),
            "rig.toml line 6: angles_deg: stop 3 is stop 1 again, at 360 degrees");
  EXPECT_EQ(WhyNot("count = 2\nstep_deg = 0\n"), "rig.toml line 6: count: stop 2 is stop 1 again, at 0 degrees");
  ExpectRefused(ParseRig(Replaced(kGantryRig, "[0.2, 0.1]", "[0, 0.1]"), "rig.toml"),
                {"line 14: positions_m: stop 2 is stop 1 again"});
}

TEST(RigStops, AreRefusedWhenTheyAreNotSaidInOneWay) {
  EXPECT_EQ(WhyNot(""), "rig.toml line 5: [stops] of a turntable needs angles_deg or count");
  EXPECT_EQ(WhyNot("angles_deg = [0]\ncount = 3\n"), "rig.toml line 7: count: angles_deg says every stop already");
  EXPECT_EQ(WhyNot("step_deg = 30\n"), "rig.toml line 6: step_deg needs stops.count, the number of stops");
  EXPECT_EQ(WhyNot("count = 0\n"), "rig.toml line 6: count = 0 is outside its range, a whole number from 1 to 3600");
  EXPECT_EQ(WhyNot("angles_deg = [0, \"x\"]\n"),
            "rig.toml line 6: angles_deg[1] must be a number in degrees from -36000 to 36000");
  EXPECT_EQ(WhyNot("angles_rad = [0]\n"),
            "rig.toml line 6: angles_rad: unknown in [stops]; did you mean angles_deg (degrees)?");
}

TEST(RigStops, OfAGantryHaveAPositionForEachAxis) {
  const auto spoilt = [](const std::string& stops) {
    return ParseRig(Replaced(kGantryRig, "[[0, 0.1], [0.2, 0.1]]", stops), "rig.toml");
  };
  ExpectRefused(spoilt("[[0, 0.1], [0.2]]"), {"line 14: positions_m: stop 2 has 1 positions, the rig has 2 axes"});
  ExpectRefused(spoilt("[0, 0.1]"), {"line 14: positions_m must be a list of one to 3600 lists of numbers in metres"});
  ExpectRefused(spoilt("[[0, 101]]"), {"line 14: positions_m[1] = 101", "metres from -100 to 100"});
  ExpectRefused(ParseRig(Replaced(kGantryRig, "positions_m = [[0, 0.1], [0.2, 0.1]]\n", ""), "rig.toml"),
                {"line 13: [stops] of a gantry needs positions_m"});
}

TEST(RigStops, AnArmHasNone) {
  const std::string arm = "[positioner]\nkind = \"arm\"\ncarries = \"cameras\"\n[stops]\n";
  ExpectRefused(ParseRig(arm, "rig.toml"), {"line 4: [stops]: an arm tells its stops itself"});
  ExpectRefused(ParseRig(arm + "count = 3\n", "rig.toml"), {"line 5: count: not a key of the kind arm"});
}

}  // namespace
}  // namespace rigcal
