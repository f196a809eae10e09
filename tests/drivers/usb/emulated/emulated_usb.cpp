#include "tests/drivers/usb/emulated/emulated_usb.h"

#include <cstdlib>

#include "sim_fixtures/u3v/u3v_descriptors.h"

namespace rigcal {

Result<sim::UsbTestbed*> EmulatedUsb() {
  // one for ever: see UsbTestbed
  static const Result<std::unique_ptr<sim::UsbTestbed>> testbed = sim::UsbTestbed::Start();
  if (!testbed) return Fail(testbed.error());
  return testbed->get();
}

sim::UsbPlug PlugOf(const sim::U3vCameraSpec& spec, const std::string& port_path) {
  return {.port_path = port_path,
          .vendor = spec.vendor,
          .model = spec.model,
          .serial = spec.serial,
          .descriptors = sim::U3vDescriptors()};
}

void WithEmulatedUsb::SetUp() {
  const Result<sim::UsbTestbed*> usb = EmulatedUsb();
  if (!usb && std::getenv("RIGCAL_NEEDS_PEERS") != nullptr) FAIL() << usb.error().message;
  if (!usb) GTEST_SKIP() << usb.error().message;
  usb_ = *usb;
}

void WithEmulatedUsb::TearDown() {
  if (usb_ != nullptr) usb_->UnplugAll();
}

void WithEmulatedUsb::Plug(const std::string& port_path, const std::string& serial, const sim::Bytes& descriptors,
                           int speed_mbit_per_s) {
  sim::UsbPlug plug = PlugOf({.serial = serial}, port_path);
  plug.descriptors = descriptors;
  plug.speed_mbit_per_s = speed_mbit_per_s;
  const Result<void> plugged =
      usb_->Plug(plug, std::make_shared<sim::U3vCamera>(sim::U3vCameraSpec{.serial = serial}, nullptr));
  ASSERT_TRUE(plugged) << plugged.error().message;
}

}  // namespace rigcal
