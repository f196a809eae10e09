#include "config/rig_hardware.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "config/rig_file.h"
#include "tests/config/example_rig_file.h"
#include "tests/config/refusals.h"
#include "tests/config/temporary_folder.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;

RigFile Parsed(const std::string& text) {
  Result<RigFile> rig = ParseRig(text, "studio/rig.toml");
  EXPECT_TRUE(rig) << Message(rig);
  return rig ? std::move(*rig) : RigFile{};
}

/// The text with one part of it spoilt is refused in words that hold all the parts.
void ExpectSpoilt(const char* text, const std::string& from, const std::string& to,
                  const std::vector<std::string>& parts) {
  SCOPED_TRACE(to);
  ExpectRefused(ParseRig(Replaced(text, from, to), "rig.toml"), parts);
}

TEST(RigHardware, ReadsEveryKeyOfACamera) {
  const RigFile rig = Parsed(kWholeRig);
  ASSERT_EQ(rig.cameras.size(), 2u);
  const CameraSettings& left = rig.cameras[0];
  EXPECT_EQ(left.id, "left");
  EXPECT_EQ(left.driver, "genicam");
  EXPECT_EQ(left.serial, "S1");
  EXPECT_EQ(left.pixel_format, "BayerRG12");
  EXPECT_EQ(left.trigger, CameraTrigger::kHardware);
  EXPECT_EQ(left.exposure_us, 8000);
  EXPECT_EQ(left.gain_db, 1.5);
  EXPECT_EQ(left.packet_bytes, 8000);
  ASSERT_TRUE(left.region);
  EXPECT_EQ(left.region->left_px, 8);
  EXPECT_EQ(left.region->top_px, 16);
  EXPECT_EQ(left.region->width_px, 640);
  EXPECT_EQ(left.region->height_px, 480);
  EXPECT_EQ(left.lens, "25 mm");
  EXPECT_EQ(left.focus_m, 0.75);
  EXPECT_EQ(rig.cameras[1].address, "127.0.0.2");
  EXPECT_EQ(rig.cameras[1].trigger, CameraTrigger::kSoftware);
}

TEST(RigHardware, ReadsEveryKeyOfATurntable) {
  const RigFile rig = Parsed(kWholeRig);
  const PositionerSettings& device = rig.positioner;
  EXPECT_EQ(device.driver, "linuxcnc");
  EXPECT_EQ(device.address, "127.0.0.1:5007");
  EXPECT_EQ(device.settle_s, 0.25);
  EXPECT_EQ(device.move_timeout_s, 60);
  EXPECT_NEAR(device.position_tolerance_rad, 0.05 * kDegree, 1e-15);
  ASSERT_EQ(device.axes.size(), 1u);
  const AxisSettings& axis = device.axes[0];
  EXPECT_EQ(axis.name, kTableAxis);
  EXPECT_EQ(rig.axes, std::vector<std::string>{kTableAxis});
  EXPECT_EQ(axis.device_letter, "C");
  EXPECT_EQ(axis.unit, AxisUnit::kRadian);
  EXPECT_NEAR(axis.least.value(), -10 * kDegree, 1e-12);
  EXPECT_NEAR(axis.most.value(), 370 * kDegree, 1e-12);
  EXPECT_NEAR(axis.speed, 20 * kDegree, 1e-12);
  EXPECT_EQ(axis.approach, 1);
  EXPECT_NEAR(axis.backlash, 2 * kDegree, 1e-12);
}

TEST(RigHardware, ReadsCaptureKeepAndChart) {
  const RigFile rig = Parsed(kWholeRig);
  EXPECT_EQ(rig.capture.picture_s, 3);
  EXPECT_EQ(rig.capture.recover_s, 6);
  EXPECT_EQ(rig.capture.retakes, 1);
  EXPECT_EQ(rig.capture.max_saturated, 0.4);
  EXPECT_EQ(rig.capture.min_brightness, 0.02);
  EXPECT_EQ(rig.capture.min_sharpness, 0.2);
  EXPECT_FALSE(rig.capture.refuse_identical);
  EXPECT_EQ(rig.keep.max_age_days, 30);
  EXPECT_EQ(rig.keep.max_count, 100);
  EXPECT_EQ(rig.publish.rig, "studio");
  EXPECT_EQ(rig.publish.folder, "studio/published") << "paths begin at the rig file";
  EXPECT_EQ(rig.publish.formats, (std::vector<std::string>{"colmap", "opencv"}));
  EXPECT_TRUE(rig.publish.undistorted);
  EXPECT_EQ(rig.keep.min_free_bytes, 20e9);
  EXPECT_EQ(rig.board, "studio/board.toml") << "paths begin at the rig file";
}

TEST(RigHardware, ReadsWhenACameraDrifts) {
  EXPECT_EQ(Parsed(std::string(kWholeRig) + "[drift]\nlimit_px = 0.4\n").drift.limit_px, 0.4);
  EXPECT_EQ(Parsed(kWholeRig).drift.limit_px, kDriftLimitPx);
  ExpectRefused(ParseRig(std::string(kWholeRig) + "[drift]\nlimit_px = 0\n", "rig.toml"), {"limit_px", "0.01", "10"});
}

TEST(RigHardware, ReadsAGantrysAxesByTheirNames) {
  const RigFile rig = Parsed(kGantryRig);
  const std::vector<AxisSettings>& axes = rig.positioner.axes;
  ASSERT_EQ(axes.size(), 2u);
  EXPECT_EQ(axes[0].name, "x");
  EXPECT_EQ(axes[0].device_letter, "X");
  EXPECT_FALSE(axes[0].least);
  EXPECT_EQ(axes[1].device_letter, "Z");
  EXPECT_EQ(axes[1].name, "z");
  EXPECT_EQ(axes[1].unit, AxisUnit::kMetre);
  EXPECT_EQ(axes[1].most, 0.5);
  EXPECT_EQ(axes[1].speed, 0.1);
  EXPECT_EQ(axes[1].approach, -1);
  EXPECT_EQ(axes[1].backlash, 0.002);
}

TEST(RigHardware, ATurntablesAxisHasItsUsualLetter) {
  const auto letter = [](const std::string& driver, const std::string& address) {
    const RigFile rig =
        Parsed("[positioner]\nkind = \"turntable\"\ndriver = \"" + driver + "\"\naddress = \"" + address + "\"\n");
    return rig.positioner.axes.at(0).device_letter;
  };
  EXPECT_EQ(letter("linuxcnc", "127.0.0.1:5007"), "C");
  EXPECT_EQ(letter("grbl", "/dev/ttyUSB0"), "X");
}

TEST(RigHardware, ASimulatedStudioBringsItsCameras) {
  const RigFile rig = Parsed(kSimRig);
  ASSERT_TRUE(rig.sim);
  EXPECT_EQ(rig.sim->scene, "plaster");
  EXPECT_NEAR(rig.sim->step_error_rad, 0.02 * kDegree, 1e-15);
  ASSERT_EQ(rig.cameras.size(), 3u);
  EXPECT_EQ(rig.cameras[2].id, "cam2");
  EXPECT_EQ(rig.cameras[2].driver, "sim");
}

TEST(RigHardware, ARigFileWithoutDevicesIsOneForSeeding) {
  const RigFile rig = Parsed("[positioner]\nkind = \"turntable\"\n");
  EXPECT_TRUE(rig.positioner.driver.empty());
  EXPECT_TRUE(rig.cameras.empty());
  EXPECT_TRUE(rig.capture.stops.empty());
  EXPECT_FALSE(rig.sim);
  EXPECT_FALSE(rig.replay);
  EXPECT_FALSE(rig.keep.max_count);
}

TEST(RigHardware, TellsAWrongUnitFromAnUnknownKey) {
  EXPECT_EQ(Message(ParseRig(Replaced(kWholeRig, "exposure_us", "exposure_ms"), "rig.toml")),
            "rig.toml line 24: exposure_ms: unknown in [[camera]]; did you mean exposure_us (microseconds)?");
  ExpectSpoilt(kWholeRig, "gain_db", "gain_percent", {"line 25: gain_percent", "gain_db (decibels)"});
  ExpectSpoilt(kWholeRig, "speed_deg_s", "speed_rad_s", {"speed_deg_s (degrees per second)"});
  ExpectSpoilt(kWholeRig, "limits_deg", "limits_m", {"[[positioner.axis]]; did you mean limits_deg (degrees)?"});
  ExpectSpoilt(kGantryRig, "backlash_m", "backlash_mm", {"backlash_m (metres)"});
  ExpectSpoilt(kWholeRig, "min_free_gb", "min_free_tb", {"min_free_gb (gigabytes"});
  ExpectSpoilt(kWholeRig, "pixel_format", "pixelformat", {"line 22", "did you mean pixel_format?"});
  ExpectSpoilt(kWholeRig, "picture_s", "exposure_us", {"unknown in [capture]; it is a key of [[camera]]"});
  ExpectSpoilt(kWholeRig, "lens", "owner", {"line 28: owner: unknown in [[camera]]; known are id, driver, serial"});
  ExpectSpoilt(kGantryRig, "axes =", "wobble_sigma_deg =", {"not a key of the kind gantry, only of turntable"});
}

TEST(RigHardware, TellsLineKeyAndRange) {
  ExpectSpoilt(kWholeRig, "8000\ngain", "0\ngain",
               {"rig.toml line 24: exposure_us = 0", "microseconds from 1 to 6e+07"});
  ExpectSpoilt(kWholeRig, "= 8000\nregion", "= 100\nregion", {"line 26: packet_bytes = 100", "576 to 16384"});
  ExpectSpoilt(kWholeRig, "= 8000\nregion", "= 8000.5\nregion", {"line 26: packet_bytes must be a whole number"});
  ExpectSpoilt(kWholeRig, "[8, 16, 640, 480]", "[8, 16, 640]", {"line 27: region_px", "a list of four whole numbers"});
  ExpectSpoilt(kWholeRig, "[8, 16,", "[-8, 16,", {"line 27: region_px[0] = -8", "from 0 to 65536"});
  ExpectSpoilt(kWholeRig, "[8, 16, 640, 480]", "[8, 16, 640, 0]", {"line 27: region_px of camera 'left' is empty"});
  ExpectSpoilt(kWholeRig, "\"S1\"", "17", {"line 21: serial must be a text in quotes"});
  ExpectSpoilt(kWholeRig, "\"S1\"", "\"\"", {"line 21: serial must be a text in quotes of 1 to 256 characters"});
  ExpectSpoilt(kWholeRig, "\"left\"", "\"../left\"",
               {"line 19: id must be a name in quotes of 1 to 64 letters, digits"});
  ExpectSpoilt(kWholeRig, "25 mm", std::string(257, 'x'), {"line 28: lens must be a text in quotes of 1 to 256"});
  ExpectSpoilt(kWholeRig, "BayerRG12", "RGB8", {"line 22: pixel_format must be one of \"Mono8\", \"Mono10\""});
  ExpectSpoilt(kWholeRig, "\"hardware\"", "\"line 1\"", {"line 23: trigger must be one of \"software\", \"hardware\""});
  ExpectSpoilt(kWholeRig, "settle_s = 0.25", "settle_s = -1", {"line 5: settle_s = -1", "seconds from 0 to 60"});
  ExpectSpoilt(kWholeRig, "settle_s = 0.25", "settle_s = nan", {"line 5: settle_s = nan"});
  ExpectSpoilt(kWholeRig, "[-10, 370]", "[370, -10]", {"line 10: limits_deg of the axis 'table'", "[least, most]"});
  ExpectSpoilt(kWholeRig, "\"up\"", "\"left\"", {"line 12: approach must be one of \"up\", \"down\""});
  ExpectSpoilt(kWholeRig, "max_saturated = 0.4", "max_saturated = 40", {"max_saturated = 40", "from 0 to 1"});
  ExpectSpoilt(kWholeRig, "max_count = 100", "max_count = 0", {"max_count = 0", "a whole number from 1 to"});
  ExpectSpoilt(kWholeRig, "\"board.toml\"", "7", {"board must be a text"});
  ExpectSpoilt(kSimRig, "plaster", "figure", {"scene must be one of \"textured\", \"plaster\", \"thin\""});
}

TEST(RigHardware, RefusesWhatIsMissing) {
  ExpectSpoilt(kWholeRig, "id = \"left\"\n", "", {"rig.toml line 18: camera.id is missing, a name"});
  ExpectSpoilt(kWholeRig, "driver = \"genicam\"\n", "", {"line 18: camera.driver is missing, one of \"genicam\""});
  ExpectSpoilt(kWholeRig, "board = \"board.toml\"\n", "", {"chart.board is missing"});
  ExpectSpoilt(kWholeRig, "\"opencv\"", "\"sketch\"", {"line 51", "'sketch' is no format"});
  ExpectSpoilt(kWholeRig, "\"studio\"", "\"a b\"", {"rig must be a name"});
  ExpectSpoilt(kWholeRig, "address = \"127.0.0.1:5007\"\n", "",
               {"line 3: driver = \"linuxcnc\": positioner.address is missing, HOST:PORT"});
  ExpectSpoilt(kGantryRig, "address = \"/dev/ttyUSB0\"\n", "", {"positioner.address is missing, a serial device"});
  ExpectSpoilt(kWholeRig, "serial = \"S1\"\n", "", {"line 19: id: camera 'left' has neither serial nor address"});
  ExpectSpoilt(kGantryRig, "name = \"z\"\n", "", {"line 7: positioner.axis.name is missing"});
  ExpectSpoilt(kGantryRig, "[\"x\", \"z\"]", "[\"x\", \"lift\"]",
               {"line 8: name = \"z\" is not one of positioner.axes"});
  ExpectSpoilt(kSimRig, "\"sim\"", "\"replay\"",
               {"rig.toml: a device has the driver replay: replay.recording is missing"});
}

TEST(RigHardware, RefusesCamerasThatCannotBeToldApart) {
  EXPECT_EQ(Message(ParseRig(Replaced(kWholeRig, "address = \"127.0.0.2\"", "serial = \"S1\""), "rig.toml")),
            "rig.toml line 33: serial = \"S1\" of camera 'right' is that of camera 'left' (line 18) too");
  ExpectSpoilt(kWholeRig, "serial = \"S1\"", "address = \"127.0.0.2\"",
               {"line 33: address = \"127.0.0.2\" of camera 'right' is that of camera 'left'"});
  ExpectSpoilt(kWholeRig, "\"right\"", "\"left\"", {"line 31: id = \"left\"", "line 18"});
}

TEST(RigHardware, RefusesWhatContradictsItself) {
  ExpectSpoilt(kWholeRig, "127.0.0.2", "300.0.0.2", {"line 33: address = \"300.0.0.2\" of camera 'right'", "IPv4"});
  ExpectSpoilt(kWholeRig, "exposure_us = 8000", "exposure_us = 3e6",
               {"line 24: exposure_us = 3000000", "camera 'left'", "capture.picture_s = 3 seconds"});
  ExpectSpoilt(kWholeRig, ":5007", ":70000", {"line 4: address = \"127.0.0.1:70000\"", "the port from 1 to 65535"});
  ExpectSpoilt(kWholeRig, "\"linuxcnc\"", "\"arm\"", {"line 3: driver = \"arm\" does not move the axes"});
  ExpectSpoilt(kWholeRig, "approach = \"up\"\n", "", {"line 12: backlash_deg", "needs approach = \"up\" or \"down\""});
  ExpectSpoilt(kWholeRig, "letter = \"C\"", "letter = \"Q\"", {"line 9: letter must be one of \"X\", \"Y\""});
  ExpectSpoilt(kGantryRig,
               "limits_m =", "letter = \"A\"\nlimits_m =", {"line 9: letter", "one of the letters XYZ of grbl"});
  ExpectSpoilt(kGantryRig, "limits_m =", "letter = \"X\"\nlimits_m =", {"the axis 'z' has the letter X of another"});
  ExpectSpoilt(kGantryRig, "axes = [\"x\", \"z\"]", "axes = [\"lift\", \"z\"]", {"the axis 'lift' needs its letter"});
  ExpectSpoilt(kSimRig, "[sim]\n", "[[camera]]\nid = \"a\"\ndriver = \"sim\"\n[sim]\n",
               {"num_cameras = 3, but 1 [[camera]] have the driver sim"});
}

TEST(RigHardware, RefusesMoreAxesThanTheKindHas) {
  ExpectSpoilt(kWholeRig, "[stops]", "[[positioner.axis]]\n[stops]",
               {"line 14", "2 of [[positioner.axis]]", "at most 1"});
  ExpectSpoilt(kGantryRig, "[\"x\", \"z\"]", "[\"x\", \"y\", \"z\", \"w\"]", {"line 6: axes", "one to three names"});
  ExpectSpoilt(kGantryRig, "[\"x\", \"z\"]", "[\"\", \"z\"]", {"line 6: axes must be different names in quotes"});
  ExpectSpoilt(kGantryRig, "[stops]", "[[positioner.axis]]\nname = \"z\"\n[stops]",
               {"line 14: name", "'z' is there twice"});
  const std::string arm = "[positioner]\nkind = \"arm\"\ncarries = \"object\"\n";
  ExpectRefused(ParseRig(arm + "[[positioner.axis]]\nname = \"a\"\n", "rig.toml"), {"line 5: name", "arm"});
  ExpectRefused(ParseRig(arm + "[[positioner.axis]]\n", "rig.toml"), {"line 4: axis", "an arm has no axes"});
  ExpectRefused(ParseRig(arm + "driver = \"grbl\"\naddress = \"x\"\n", "rig.toml"), {"line 4", "does not move an arm"});
}

TEST(RigHardware, RefusesTablesThatAreNotWrittenAsOne) {
  ExpectSpoilt(kWholeRig, "[keep]", "[[keep]]", {"line 42: keep must be a table, [keep]"});
  ExpectRefused(ParseRig("[positioner]\nkind = \"arm\"\ncarries = \"object\"\n[camera]\nid = \"a\"\n", "rig.toml"),
                {"line 4: camera must be a table, [[camera]]"});
  ExpectSpoilt(kGantryRig, "[[positioner.axis]]", "[positioner.axis]",
               {"line 7: positioner.axis must be a table, [[positioner.axis]]"});
  ExpectSpoilt(kWholeRig, "[keep]", "[retain]", {"line 42: retain: unknown in a rig file; known are [positioner]"});
}

TEST(RigHardware, AnArmsFileOfPosesLiesBesideTheRigFile) {
  const std::string arm = "[positioner]\nkind = \"arm\"\ncarries = \"cameras\"\ndriver = \"arm\"\naddress = ";
  EXPECT_EQ(Parsed(arm + "\"poses.txt\"\n").positioner.address, "studio/poses.txt");
  for (const std::string listening : {"0.0.0.0:5100", "127.0.0.1:0", "[::1]:5100"}) {
    EXPECT_EQ(Parsed(arm + "\"" + listening + "\"\n").positioner.address, listening);
  }
}

TEST(RigHardware, AnArmSaysHowFarAResumedStopMayBe) {
  const PositionerSettings device =
      Parsed("[positioner]\nkind = \"arm\"\ncarries = \"cameras\"\ntolerance_deg = 0.2\ntolerance_m = 0.001\n")
          .positioner;
  EXPECT_NEAR(device.position_tolerance_rad, 0.2 * kDegree, 1e-15);
  EXPECT_EQ(device.position_tolerance_m, 0.001);
}

TEST(RigHardware, AReplayNamesItsRecording) {
  const RigFile rig = Parsed(Replaced(kSimRig, "\"sim\"", "\"replay\"") +
                             "[replay]\nrecording = \"../night\"\nat_recorded_speed = true\n");
  ASSERT_TRUE(rig.replay);
  EXPECT_EQ(rig.replay->recording, "studio/../night");
  EXPECT_TRUE(rig.replay->at_recorded_speed);
}

TEST(LoadRig, ReadsAFileAndNamesOneThatIsNotThere) {
  const TemporaryFolder folder;
  const Result<RigFile> rig = LoadRig(folder.Write("rig.toml", kWholeRig));
  ASSERT_TRUE(rig) << Message(rig);
  EXPECT_EQ(rig->board, folder.Path() / "board.toml");
  EXPECT_THAT(Message(LoadRig(folder.Path() / "none.toml")), HasSubstr("none.toml: there is no such file"));
}

}  // namespace
}  // namespace rigcal
