#include <gmock/gmock.h>

#include "core/base/random.h"
#include "drivers/usb/check_usb_before_aravis.h"
#include "drivers/usb/check_usb_descriptors.h"
#include "drivers/usb/find_usb_cameras.h"
#include "drivers/usb/usb_watch.h"
#include "sim_fixtures/u3v/u3v_descriptors.h"
#include "tests/drivers/usb/emulated/emulated_usb.h"

namespace rigcal {
namespace {

using sim::HubDescriptors;
using sim::U3vDescriptors;
using ::testing::HasSubstr;

constexpr double kHang_s = 60;  ///< an event that has not come by then never comes

class UsbCameras : public WithEmulatedUsb {
 protected:
  std::vector<FoundDevice> Find() {
    const Result<std::vector<FoundDevice>> found = FindUsbCameras(clock_, {});
    EXPECT_TRUE(found);
    return found.value_or(std::vector<FoundDevice>{});
  }
  SystemClock clock_;
};

TEST_F(UsbCameras, AreListedWithPortSerialModelAndFirmware) {
  EXPECT_TRUE(Find().empty());
  Plug("1-2.3", "A7", U3vDescriptors(0x0210));
  Plug("2-1", "B8", U3vDescriptors());
  Plug("1-4", "no camera", HubDescriptors());
  const std::vector<FoundDevice> found = Find();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].address, "1-2.3");
  EXPECT_EQ(found[0].serial, "A7");
  EXPECT_EQ(found[0].model, "rigcal Emulated");
  EXPECT_EQ(found[0].firmware, "2.10");
  EXPECT_EQ(found[0].problem, "");
  EXPECT_EQ(found[1].address, "2-1");
  usb_->Unplug("1-2.3");
  EXPECT_EQ(Find().size(), 1U);
}

TEST_F(UsbCameras, OnAUsb2PortAreReported) {
  Plug("1-1", "A7", U3vDescriptors(), 480);
  const std::vector<FoundDevice> found = Find();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].problem, HasSubstr("480 instead of 5000 Mbit/s"));
}

TEST_F(UsbCameras, WithMalformedDescriptorsAreReported) {
  sim::Bytes bytes = U3vDescriptors();
  bytes.resize(40);
  Plug("1-1", "A7", bytes);
  const std::vector<FoundDevice> found = Find();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].problem, HasSubstr("malformed (offset 20: the configuration has a wTotalLength of"));
}

TEST_F(UsbCameras, LookingForThemStopsOnRequest) {
  Plug("1-1", "A7", U3vDescriptors());
  std::stop_source stop;
  stop.request_stop();
  const Result<std::vector<FoundDevice>> found = FindUsbCameras(clock_, stop.get_token());
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kCancelled);
}

class UsbWatching : public UsbCameras {
 protected:
  void SetUp() override {
    UsbCameras::SetUp();
    if (usb_ == nullptr) return;
    Plug("1-3", "here before", U3vDescriptors());
    Result<std::unique_ptr<UsbWatch>> watch = UsbWatch::Start(clock_);
    ASSERT_TRUE(watch) << watch.error().message;
    watch_ = std::move(*watch);
  }
  void TearDown() override {
    watch_.reset();
    UsbCameras::TearDown();
  }
  void ExpectEvent(bool arrived, const std::string& port_path, const std::string& serial) {
    const Result<std::optional<UsbEvent>> event = watch_->Next(kHang_s, {});
    ASSERT_TRUE(event) << event.error().message;
    ASSERT_TRUE(*event) << "no event came";
    EXPECT_EQ((*event)->arrived, arrived);
    EXPECT_EQ((*event)->port_path, port_path);
    EXPECT_EQ((*event)->serial, serial);
  }
  std::unique_ptr<UsbWatch> watch_;
};

TEST_F(UsbWatching, SeesThemComeAndGo) {
  Plug("1-2.3", "A7", U3vDescriptors());
  ExpectEvent(true, "1-2.3", "A7");
  usb_->Unplug("1-2.3");
  ExpectEvent(false, "1-2.3", "A7");
  Plug("1-2.3", "B8", U3vDescriptors());
  ExpectEvent(true, "1-2.3", "B8");
  usb_->Unplug("1-3");
  ExpectEvent(false, "1-3", "here before");
}

TEST_F(UsbWatching, PassesOverWhatIsNoCamera) {
  Plug("1-2", "a hub", HubDescriptors());
  usb_->Unplug("1-2");
  Plug("1-4", "A7", U3vDescriptors());
  ExpectEvent(true, "1-4", "A7");
}

TEST_F(UsbWatching, EndsWithoutAnEventWhenItsTimeIsOver) {
  const Result<std::optional<UsbEvent>> event = watch_->Next(0, {});
  ASSERT_TRUE(event);
  EXPECT_FALSE(*event);
}

TEST_F(UsbWatching, StopsOnRequest) {
  std::stop_source stop;
  stop.request_stop();
  const Result<std::optional<UsbEvent>> event = watch_->Next(kHang_s, stop.get_token());
  ASSERT_FALSE(event);
  EXPECT_EQ(event.error().code, ErrorCode::kCancelled);
}

class UsbBeforeAravis : public UsbCameras {
 protected:
  static std::string Refusal(const std::string& serial = "") {
    const Result<void> may = CheckUsbBeforeAravis(serial);
    return may ? "" : may.error().message;
  }
};

TEST_F(UsbBeforeAravis, NothingIsRefusedWithoutDamage) {
  EXPECT_EQ(Refusal("A7"), "");
  Plug("1-1", "A7", U3vDescriptors());
  Plug("1-2", "a hub", HubDescriptors());
  EXPECT_EQ(Refusal(), "");
  EXPECT_EQ(Refusal("A7"), "");
}

TEST_F(UsbBeforeAravis, ADeviceThatLibusbCannotReadRefusesAll) {
  Plug("1-1", "A7", U3vDescriptors());
  sim::Bytes bytes = HubDescriptors();  // not even a camera
  bytes[18 + 9] = 3;                    // the length of its interface descriptor
  Plug("1-2.1", "broken", bytes);
  EXPECT_THAT(Refusal("A7"), HasSubstr("at port 1-2.1 has malformed descriptors (offset 27: the interface descriptor"));
  EXPECT_NE(Refusal(), "");
  usb_->Unplug("1-2.1");
  EXPECT_EQ(Refusal("A7"), "");
}

TEST_F(UsbBeforeAravis, ACameraInterfaceWithoutEndpointRefusesAll) {
  sim::Bytes bytes = U3vDescriptors();
  bytes[18 + 9 + 8 + 4] = 0;  // bNumEndpoints of the control interface
  Plug("1-1", "B8", bytes);
  EXPECT_THAT(Refusal("A7"), HasSubstr("at port 1-1 has malformed descriptors (offset 39"));
}

TEST_F(UsbBeforeAravis, WhatOnlyTheCameraItselfSuffersFromRefusesIt) {
  sim::Bytes bytes = U3vDescriptors();
  bytes[18 + 9 + 8 + 9 + 11] = 0;  // no GUID
  Plug("1-1", "B8", bytes);
  Plug("1-2", "A7", U3vDescriptors());
  EXPECT_EQ(Refusal("A7"), "");
  EXPECT_THAT(Refusal("B8"), HasSubstr("'B8' at port 1-1 has malformed descriptors: offset 55"));
}

/// The two readers of descriptors agree: what the strict one passes as a camera, libusb can read.
TEST_F(UsbBeforeAravis, WhatIsWellFormedIsReadByLibusb) {
  constexpr int kNumMutations = 60;
  Random random(7);
  int well_formed = 0, refused = 0;
  for (int i = 0; i < kNumMutations; ++i) {
    sim::Bytes bytes = U3vDescriptors();
    bytes[18 + random.Index(bytes.size() - 18)] = static_cast<std::uint8_t>(random.Index(64));
    Plug("1-1", "A7", bytes);
    const UsbDescriptorCheck check = CheckUsbDescriptors(bytes);
    const std::string refusal = Refusal("A7");
    EXPECT_EQ(refusal.empty(), !check.says_usb3_vision || check.flaw.empty()) << refusal << check.flaw;
    ++(refusal.empty() ? well_formed : refused);
  }
  EXPECT_GT(well_formed, 10);
  EXPECT_GT(refused, 10);
}

}  // namespace
}  // namespace rigcal
