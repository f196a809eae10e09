#include <gmock/gmock.h>

#include <cstring>
#include <thread>

#include "sim_fixtures/u3v/u3v_descriptors.h"
#include "tests/drivers/usb/camera/u3v_peer.h"
#include "tests/drivers/usb/emulated/emulated_usb.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

INSTANTIATE_TEST_SUITE_P(U3v, CameraContract,
                         ::testing::Values([] { return std::unique_ptr<CameraPeer>(U3vPeer::Start()); }));

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && std::memcmp(a.ptr(), b.ptr(), a.total() * a.elemSize()) == 0;
}

class U3vDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    peer_ = U3vPeer::Start();
    if (!peer_) GTEST_SKIP() << "USB cannot be emulated here";
  }
  void Open(const CameraSettings& settings) {
    auto opened = peer_->Open(settings);
    ASSERT_TRUE(opened) << opened.error().message;
    camera_ = std::move(*opened);
  }
  void Open() { Open(peer_->Settings()); }
  Result<CapturedPicture> Take(int shot) {
    peer_->Arrange(shot);
    if (Result<void> ready = camera_->MakeReady({}); !ready) return Fail(ready.error());
    if (Result<void> fired = camera_->Fire(); !fired) return Fail(fired.error());
    return camera_->Collect(U3vPeer::kHang_s, {});
  }
  void ExpectTaken(int shot) {
    const Result<CapturedPicture> picture = Take(shot);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_TRUE(Same(picture->pixels, peer_->Expected(shot))) << "shot " << shot;
  }
  void ExpectRefused(const CameraSettings& settings, ErrorCode code, const std::string& why) {
    const auto opened = peer_->Open(settings);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, code) << opened.error().message;
    EXPECT_THAT(opened.error().message, HasSubstr("camera 'top'"));
    EXPECT_THAT(opened.error().message, HasSubstr(why));
  }

  std::unique_ptr<U3vPeer> peer_;
  std::unique_ptr<CameraDevice> camera_;
};

TEST_F(U3vDevice, SaysWhatItIsAndHowItTookThePicture) {
  CameraSettings settings = peer_->Settings();
  settings.exposure_us = 2500;
  settings.gain_db = 6;
  Open(settings);
  EXPECT_EQ(camera_->Identity().serial, "U3V7");
  EXPECT_EQ(camera_->Identity().model, "rigcal Emulated");
  EXPECT_DOUBLE_EQ(camera_->Identity().temperature_celsius.value(), 41.5);
  const Result<CapturedPicture> picture = Take(0);
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_DOUBLE_EQ(picture->exposure_us.value(), 2500);
  EXPECT_DOUBLE_EQ(picture->gain_db.value(), 6);
}

TEST_F(U3vDevice, IsOpenedByItsPort) {
  peer_->Unplug();
  peer_->PlugIn("1-2.3");
  CameraSettings settings = {.id = "top", .driver = "genicam", .address = "1-2.3"};
  Open(settings);
  ExpectTaken(0);
  settings.address = "1-2.4";
  ExpectRefused(settings, ErrorCode::kNotFound, "found: 'U3V7' at port 1-2.3");
}

TEST_F(U3vDevice, UnpluggedInTheMiddleOfAPictureIsReportedAndItComesBack) {
  Open();
  ExpectTaken(0);
  sim::U3vFaults stalls;
  stalls.stalls_after_bytes = 1;  // after its payload, before its trailer
  peer_->Camera().Set(stalls);
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  std::jthread puller([this] {
    EXPECT_TRUE(peer_->Camera().AwaitStalled(U3vPeer::kHang_s));
    peer_->Unplug();
  });
  const Result<CapturedPicture> lost = camera_->Collect(10 * U3vPeer::kHang_s, {});  // far longer than it may take
  puller.join();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, ErrorCode::kDevice) << lost.error().message;
  EXPECT_THAT(lost.error().message, HasSubstr("camera 'top'"));
  EXPECT_FALSE(camera_->MakeReady({}));

  peer_->Camera().Set({});
  peer_->PlugIn("1-4");  // at another port: the serial number counts
  const Result<void> restored = camera_->Restore(U3vPeer::kHang_s, {});
  ASSERT_TRUE(restored) << restored.error().message;
  ExpectTaken(1);
}

TEST_F(U3vDevice, WithMalformedDescriptorsIsRefused) {
  peer_->Unplug();
  sim::UsbPlug plug = PlugOf(U3vPeer::Small());
  plug.descriptors[35] = 3;  // the length of its control interface: Aravis crashes on that
  peer_->PlugIn(plug);
  ExpectRefused(peer_->Settings(), ErrorCode::kDevice,
                "malformed descriptors (offset 35: the interface descriptor has");
}

TEST_F(U3vDevice, IsNotOpenedBesideOneThatAravisWouldCrashOn) {
  sim::UsbPlug plug = PlugOf({.serial = "broken"}, "1-3");
  plug.descriptors[22] = 40;  // interfaces
  peer_->PlugIn(plug);
  ExpectRefused(peer_->Settings(), ErrorCode::kDevice, "the device at port 1-3 has malformed descriptors");
}

TEST_F(U3vDevice, TwoWithOneSerialNumberAreRefused) {
  peer_->PlugIn("1-2");
  ExpectRefused(peer_->Settings(), ErrorCode::kBadInput,
                "two cameras have the serial number 'U3V7', at ports 1-1 and 1-2");
}

TEST_F(U3vDevice, ADamagedPictureDoesNotSpoilTheNextOnes) {
  Open();
  for (int shot = 0; shot < 4; ++shot) {
    sim::U3vFaults faults;
    faults.truncated = shot % 2 == 0;
    peer_->Camera().Set(faults);
    const Result<CapturedPicture> picture = Take(shot);
    EXPECT_EQ(picture.has_value(), shot % 2 == 1) << shot;
    if (picture) {
      EXPECT_TRUE(Same(picture->pixels, peer_->Expected(shot)));
    }
  }
}

}  // namespace
}  // namespace rigcal
