#include <gmock/gmock.h>

#include "drivers/registry.h"

namespace rigcal {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

FoundDevice Camera(const std::string& serial, const std::string& address) {
  return {.driver = "genicam", .kind = DeviceKind::kCamera, .address = address, .serial = serial};
}

FoundDevice Table(const std::string& driver, const std::string& address) {
  return {.driver = driver, .kind = DeviceKind::kPositioner, .address = address};
}

TEST(MissingDevices, NamesTheCamerasThatAreNotThereAndWhatIs) {
  const RigHardware rig = {.cameras = {{.id = "left", .driver = "genicam", .serial = "A1"},
                                       {.id = "right", .driver = "genicam", .serial = "A2"},
                                       {.id = "top", .driver = "genicam", .address = "10.0.0.9"}}};
  EXPECT_THAT(MissingDevices(rig, {Camera("A1", "10.0.0.7"), Camera("", "10.0.0.8")}),
              ElementsAre("camera 'right': no camera with the serial number A2 is found; found: A1, 10.0.0.8",
                          "camera 'top': no camera with the address 10.0.0.9 is found; found: A1, 10.0.0.8"));
  EXPECT_THAT(MissingDevices(rig, {Camera("A1", "x"), Camera("A2", "y"), Camera("A3", "10.0.0.9")}), IsEmpty());
}

TEST(MissingDevices, APositionerIsNoCamera) {
  const RigHardware rig = {.cameras = {{.id = "left", .driver = "genicam", .serial = "A1"}}};
  FoundDevice table = Table("grbl", "/dev/ttyUSB0");
  table.serial = "A1";
  EXPECT_THAT(MissingDevices(rig, {table}),
              ElementsAre("camera 'left': no camera with the serial number A1 is found; no camera is found"));
}

TEST(MissingDevices, NamesThePositioner) {
  const RigHardware rig = {.positioner = {.driver = "linuxcnc", .address = "10.0.0.5:5007"}};
  EXPECT_THAT(MissingDevices(rig, {Table("linuxcnc", "127.0.0.1:5007")}),
              ElementsAre("positioner: no linuxcnc is found at 10.0.0.5:5007; found: linuxcnc at 127.0.0.1:5007"));
  EXPECT_THAT(MissingDevices(rig, {Table("linuxcnc", "10.0.0.5:5007")}), IsEmpty());
}

TEST(MissingDevices, NamesOfOneSerialLineAreOneDevice) {
  const RigHardware rig = {.positioner = {.driver = "grbl", .address = "/dev/../dev/null"}};
  EXPECT_THAT(MissingDevices(rig, {Table("grbl", "/dev/null")}), IsEmpty());
  EXPECT_THAT(MissingDevices(rig, {Table("grbl", "/dev/zero")}).size(), 1);
}

TEST(MissingDevices, WhatSomebodyElsePlaysIsNeverMissing) {
  for (const char* driver : {"arm", "sim", "replay", ""}) {
    const RigHardware rig = {.cameras = {{.id = "left", .driver = "sim"}},
                             .positioner = {.driver = driver, .address = "0.0.0.0:5100"}};
    EXPECT_THAT(MissingDevices(rig, {}), IsEmpty());
  }
}

}  // namespace
}  // namespace rigcal
