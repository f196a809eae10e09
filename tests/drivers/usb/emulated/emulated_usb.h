#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "sim_fixtures/u3v/u3v_camera.h"
#include "sim_fixtures/u3v/usb_testbed.h"

namespace rigcal {

/// The emulated USB of this program, with what is plugged in; the reason where there is none.
Result<sim::UsbTestbed*> EmulatedUsb();

/// A well-formed camera's plug.
sim::UsbPlug PlugOf(const sim::U3vCameraSpec& spec, const std::string& port_path = "1-1");

/// Tests with emulated USB: skipped without it, or failed where the environment must have it (RIGCAL_NEEDS_PEERS).
/// Nothing is plugged in at their beginning.
class WithEmulatedUsb : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Plugs a camera in that nobody will take pictures with, its descriptors changed.
  void Plug(const std::string& port_path, const std::string& serial, const sim::Bytes& descriptors,
            int speed_mbit_per_s = 5000);

  sim::UsbTestbed* usb_ = nullptr;
};

}  // namespace rigcal
