#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>

#include "drivers/genicam/genicam_driver.h"
#include "tests/drivers/genicam/gige_peer.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr double kPicture_s = GigePeer::kHang_s;
constexpr sim::GigeEndpoint kElsewhere{0x0a010203, 4711};  // 10.1.2.3
constexpr sim::GigeEndpoint kThisMachine{0x7f000001, 4711};

INSTANTIATE_TEST_SUITE_P(Genicam, CameraContract,
                         ::testing::Values([] { return std::unique_ptr<CameraPeer>(GigePeer::Start()); }));

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && std::memcmp(a.ptr(), b.ptr(), a.total() * a.elemSize()) == 0;
}

class GenicamDevice : public ::testing::Test {
 protected:
  void SetUp() override { Start({}); }
  void Start(const sim::GigeDeviceOptions& options) {
    camera_.reset();
    peer_.reset();
    peer_ = GigePeer::Start(options);
    if (!peer_) GTEST_SKIP() << "no simulated camera can run here";
  }
  void Open(const CameraSettings& settings) {
    auto opened = peer_->Open(settings);
    ASSERT_TRUE(opened) << opened.error().message;
    camera_ = std::move(*opened);
  }
  void Open() { Open(peer_->Settings()); }
  Result<CapturedPicture> Take(int shot) {
    if (!camera_) return Fail(ErrorCode::kDevice, "it could not be opened");
    peer_->Arrange(shot);
    if (Result<void> ready = camera_->MakeReady({}); !ready) return Fail(ready.error());
    if (Result<void> fired = camera_->Fire(); !fired) return Fail(fired.error());
    return camera_->Collect(kPicture_s, {});
  }
  void ExpectTaken(int shot) {
    const Result<CapturedPicture> picture = Take(shot);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_TRUE(Same(picture->pixels, peer_->Expected(shot))) << "shot " << shot;
  }
  void ExpectRefused(const CameraSettings& settings, ErrorCode code, const std::vector<std::string>& parts) {
    const auto opened = peer_->Open(settings);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, code) << opened.error().message;
    EXPECT_THAT(opened.error().message, HasSubstr("camera 'left'"));
    for (const std::string& part : parts) EXPECT_THAT(opened.error().message, HasSubstr(part));
  }

  std::unique_ptr<GigePeer> peer_;
  std::unique_ptr<CameraDevice> camera_;
};

TEST_F(GenicamDevice, LostPacketsAreAskedForAgain) {
  CameraSettings settings = peer_->Settings();
  settings.packet_bytes = 600;  // 138 packets a picture
  Open(settings);
  peer_->Fault([](auto& faults) { faults.loss = 0.02; });
  for (int shot = 0; shot < 10; ++shot) ExpectTaken(shot);
  EXPECT_GE(peer_->Device().Counts().lost, 5);
  EXPECT_GE(peer_->Device().Counts().resent, 5);
}

TEST_F(GenicamDevice, WithoutResendEveryDamagedPictureIsNoticed) {
  Start({.can_resend = false});
  peer_->Options().frame_retention_s = 0.1;
  CameraSettings settings = peer_->Settings();
  settings.packet_bytes = 600;
  Open(settings);
  peer_->Fault([](auto& faults) { faults.loss = 0.004; });
  int num_whole = 0, num_damaged = 0;
  for (int shot = 0; shot < 15; ++shot) {
    const std::uint64_t lost_before = peer_->Device().Counts().lost;
    const Result<CapturedPicture> picture = Take(shot);
    if (picture) {
      ++num_whole;
      EXPECT_TRUE(Same(picture->pixels, peer_->Expected(shot)));
      EXPECT_EQ(peer_->Device().Counts().lost, lost_before);
    } else {
      ++num_damaged;
      EXPECT_EQ(picture.error().code, ErrorCode::kDevice) << picture.error().message;
      EXPECT_THAT(picture.error().message, HasSubstr("came incomplete"));
      EXPECT_THAT(picture.error().message, HasSubstr(fmt::format("the {}. since it was opened", num_damaged)));
    }
  }
  EXPECT_GE(num_whole, 1);
  EXPECT_GE(num_damaged, 3);
}

TEST_F(GenicamDevice, AnotherControllerIsNamedUntilItLetsGo) {
  Open();
  ASSERT_TRUE(camera_);
  ExpectTaken(0);
  peer_->Device().SetController(kElsewhere);
  const Result<void> ready = camera_->MakeReady({});
  ASSERT_FALSE(ready);
  EXPECT_EQ(ready.error().code, ErrorCode::kDevice);
  EXPECT_THAT(ready.error().message, HasSubstr("control of it is lost"));
  const Result<void> restored = camera_->Restore(0, {});
  ASSERT_FALSE(restored);
  EXPECT_THAT(restored.error().message, HasSubstr("10.1.2.3"));
  EXPECT_FALSE(camera_->MakeReady({}));
  peer_->Device().SetController(std::nullopt);
  const Result<void> again = camera_->Restore(kPicture_s, {});
  ASSERT_TRUE(again) << again.error().message;
  ExpectTaken(1);
}

TEST_F(GenicamDevice, ACameraThatForgotItsControllerIsSetAgain) {
  CameraSettings settings = peer_->Settings();
  settings.exposure_us = 2500;
  Open(settings);
  ExpectTaken(0);
  peer_->Device().Kill();
  ASSERT_TRUE(peer_->Device().Revive());
  EXPECT_FALSE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Restore(kPicture_s, {}));
  const Result<CapturedPicture> picture = Take(1);
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_NEAR(*picture->exposure_us, 2500, 1e-3);
}

TEST_F(GenicamDevice, WhoControlsItExclusivelyIsToldAsFarAsItSays) {
  peer_->Device().SetController(kElsewhere, true);
  ExpectRefused(peer_->Settings(), ErrorCode::kDevice, {"controlled by a program that it does not name, exclusively"});
  peer_->Device().SetController(kElsewhere);
  ExpectRefused(peer_->Settings(), ErrorCode::kDevice, {"controlled by 10.1.2.3"});
}

TEST_F(GenicamDevice, AProgramOfThisMachineThatIsGoneIsWaitedFor) {
  peer_->Device().SetController(kThisMachine);
  ExpectRefused(peer_->Settings(), ErrorCode::kDevice, {"another program on this machine"});
  peer_->Options().abandoned_s = kPicture_s;
  std::jthread letting_go([&] {
    peer_->Time().Wait(0.3, {});
    peer_->Device().SetController(std::nullopt);
  });
  Open();
}

TEST_F(GenicamDevice, IsFoundByItsSerialNumberAlone) {
  CameraSettings settings = peer_->Settings();
  const std::string address = std::exchange(settings.address, "");
  auto found = FindGenicamDevices(GigeReach::kThisMachine, peer_->Time(), {});
  ASSERT_TRUE(found) << found.error().message;
  const auto ours = [&] {
    return std::ranges::find_if(*found, [&](const FoundDevice& each) { return each.address == address; });
  };
  ASSERT_NE(ours(), found->end());
  EXPECT_EQ(ours()->serial, settings.serial);
  EXPECT_EQ(ours()->model, "rigcal Studio");
  EXPECT_EQ(ours()->state, "free");
  EXPECT_EQ(ours()->problem, "");
  settings.serial = ours()->serial;
  Open(settings);
  ExpectTaken(0);
  found = FindGenicamDevices(GigeReach::kThisMachine, peer_->Time(), {});
  ASSERT_TRUE(found);
  ASSERT_NE(ours(), found->end());
  EXPECT_EQ(ours()->state, "held by 127.0.0.1");
  settings.serial = "NOBODY";
  ExpectRefused(settings, ErrorCode::kNotFound, {"'NOBODY'", peer_->Settings().serial});
}

TEST_F(GenicamDevice, AnotherCameraAtItsAddressIsNotTaken) {
  CameraSettings settings = peer_->Settings();
  settings.serial = "ANOTHER";
  ExpectRefused(settings, ErrorCode::kNotFound, {settings.address, "'ANOTHER'", peer_->Settings().serial});
}

TEST_F(GenicamDevice, MoreThan8BitsAreSpreadOverTheFullScale) {
  for (const auto& [format, bits] : {std::pair("Mono10", 10), std::pair("Mono12", 12), std::pair("Mono16", 16)}) {
    CameraSettings settings = peer_->Settings();
    settings.pixel_format = format;
    Open(settings);
    const Result<CapturedPicture> picture = Take(3);
    ASSERT_TRUE(picture) << picture.error().message;
    const cv::Mat sent = GigePeer::Pattern(3, GigePeer::kWidth_px, GigePeer::kHeight_px, bits);
    cv::Mat expected;
    sent.convertTo(expected, CV_64F, 65535.0 / ((1 << bits) - 1));
    cv::Mat taken;
    picture->pixels.convertTo(taken, CV_64F);
    EXPECT_EQ(picture->pixels.type(), CV_16U);
    EXPECT_LE(cv::norm(taken, expected, cv::NORM_INF), 1.0) << format;
    EXPECT_EQ(camera_->Identity().pixel_format, format);
    camera_.reset();
  }
}

TEST_F(GenicamDevice, EachMosaicGivesItsColours) {
  const std::map<char, std::array<int, 2>> blue_green_red = {{'B', {10, 160}}, {'G', {80, 1280}}, {'R', {200, 3200}}};
  for (const std::string mosaic : {"RG", "GR", "GB", "BG"}) {
    for (const int bits : {8, 12}) {
      // The second row of a mosaic: green under red and blue, and the colour that the first row has not.
      const std::string below =
          mosaic[0] == 'G' ? std::string(mosaic[1] == 'R' ? "BG" : "RG") : std::string(mosaic[0] == 'R' ? "GB" : "GR");
      peer_->Show([&](const sim::GigeShot& shot) {
        cv::Mat sensor(shot.height_px, shot.width_px, bits > 8 ? CV_16U : CV_8U);
        for (int y = 0; y < sensor.rows; ++y) {
          for (int x = 0; x < sensor.cols; ++x) {
            const int value = blue_green_red.at((y % 2 == 0 ? mosaic : below)[x % 2])[bits > 8];
            if (bits > 8) sensor.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(value);
            if (bits <= 8) sensor.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
          }
        }
        return sensor;
      });
      CameraSettings settings = peer_->Settings();
      settings.pixel_format = fmt::format("Bayer{}{}", mosaic, bits);
      Open(settings);
      const Result<CapturedPicture> picture = Take(0);
      ASSERT_TRUE(picture) << picture.error().message;
      ASSERT_EQ(picture->pixels.channels(), 3);
      const double scale = bits > 8 ? 65535.0 / 4095 : 1;
      const cv::Scalar mean = cv::mean(picture->pixels) / scale;
      int channel = 0;
      for (const auto& [name, values] : blue_green_red) {
        EXPECT_NEAR(mean[channel++], values[bits > 8], 0.5) << settings.pixel_format << ' ' << name;
      }
      camera_.reset();
    }
  }
}

TEST_F(GenicamDevice, ItIsSetAsTheRigFileSaysAndReadBack) {
  CameraSettings settings = peer_->Settings();
  settings.exposure_us = 1234;
  settings.gain_db = 6;
  settings.region = SensorRegion{.left_px = 16, .top_px = 8, .width_px = 160, .height_px = 120};
  settings.lens = "a lens";
  Open(settings);
  const Result<CapturedPicture> picture = Take(1);
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_NEAR(*picture->exposure_us, 1234, 1e-3);
  EXPECT_NEAR(*picture->gain_db, 6, 1e-6);
  EXPECT_NEAR(*picture->temperature_celsius, 41.5, 1e-6);
  const cv::Mat part = peer_->Expected(1)(cv::Rect(16, 8, 160, 120)).clone();
  EXPECT_TRUE(Same(picture->pixels, part));
  EXPECT_EQ(camera_->Identity().width_px, 160);
  EXPECT_EQ(camera_->Identity().lens, "a lens");
  EXPECT_EQ(camera_->Identity().model, "rigcal Studio");
  EXPECT_TRUE(camera_->Linear());
}

TEST_F(GenicamDevice, WhatTheCameraDoesNotAllowIsToldWithItsRange) {
  const CameraSettings good = peer_->Settings();
  CameraSettings bad = good;
  bad.exposure_us = 5;
  ExpectRefused(bad, ErrorCode::kBadInput, {"exposure_us is 5, this camera allows 10 to 1000000"});
  bad = good, bad.gain_db = 30;
  ExpectRefused(bad, ErrorCode::kBadInput, {"gain_db is 30, this camera allows 0 to 24"});
  bad = good, bad.pixel_format = "BayerRG10";
  ExpectRefused(bad, ErrorCode::kBadInput, {"pixel_format is \"BayerRG10\", this camera allows Mono8, Mono10"});
  bad = good, bad.packet_bytes = 16384;
  ExpectRefused(bad, ErrorCode::kBadInput, {"packet_bytes is 16384, this camera allows 576 to 16000 in steps of 4"});
  bad = good, bad.region = SensorRegion{.left_px = 168, .top_px = 0, .width_px = 160, .height_px = 120};
  ExpectRefused(bad, ErrorCode::kBadInput, {"region_px is [168, 0, 160, 120]", "320 x 240"});
  bad = good, bad.region = SensorRegion{.left_px = 0, .top_px = 0, .width_px = 100, .height_px = 120};
  ExpectRefused(bad, ErrorCode::kBadInput, {"region_px's width is 100, this camera allows 8 to 320 in steps of 8"});
  bad = good, bad.pixel_format = "Mono12Packed";
  ExpectRefused(bad, ErrorCode::kUnsupported, {"Mono12Packed"});
  bad = good, bad.serial = bad.address = "";
  ExpectRefused(bad, ErrorCode::kBadInput, {"needs its serial number or its address"});
  Open(good);  // nothing of that keeps it
}

TEST_F(GenicamDevice, AGammaIsNotLinear) {
  Start({.camera = {.gamma = 0.45}});
  Open();
  ASSERT_TRUE(camera_);
  EXPECT_FALSE(camera_->Linear());
}

TEST_F(GenicamDevice, PacketsAreAsLargeAsTheyGetThrough) {
  peer_->Fault([](auto& faults) { faults.path_packet_bytes = 4000; });
  CameraSettings negotiated = peer_->Settings();
  negotiated.packet_bytes.reset();
  Open(negotiated);
  EXPECT_LE(peer_->Device().Packet_bytes(), 4000);
  EXPECT_GT(peer_->Device().Packet_bytes(), 1500);
  ExpectTaken(0);
  camera_.reset();
  CameraSettings settings = peer_->Settings();
  settings.packet_bytes = 1000;
  Open(settings);
  EXPECT_EQ(peer_->Device().Packet_bytes(), 1000);
  ExpectTaken(1);
}

TEST_F(GenicamDevice, APictureThatTheCameraHeldBackIsNotTheNextOne) {
  Open();
  ASSERT_TRUE(camera_);
  ExpectTaken(0);
  const std::uint64_t before = peer_->Device().Counts().shots;
  peer_->Fault([](auto& faults) { faults.held = true; });
  peer_->Arrange(1);
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  ASSERT_TRUE(peer_->Await([&](const auto& counts) { return counts.shots == before + 1; }));  // it has seen shot 1
  peer_->Arrange(2);
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  peer_->Fault([](auto& faults) { faults.held = false; });
  const Result<CapturedPicture> picture = camera_->Collect(kPicture_s, {});
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_TRUE(Same(picture->pixels, peer_->Expected(2)));
  EXPECT_EQ(peer_->Device().Counts().frames, before + 2) << "the picture that was held back never came";
}

TEST_F(GenicamDevice, WithoutAClockNothingIsMistakenEither) {
  Start({.camera = {.has_clock = false}});
  Open();
  ASSERT_TRUE(camera_);
  ExpectTaken(0);
  peer_->Arrange(1);
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  ASSERT_TRUE(peer_->Await([](const auto& counts) { return counts.shots == 2; }));
  ExpectTaken(2);  // the picture that was given up is not this one
  peer_->Arrange(3);
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  ASSERT_TRUE(camera_->MakeReady({}));
  EXPECT_FALSE(camera_->Collect(0.3, {})) << "nobody has fired";
}

TEST_F(GenicamDevice, AStreamThatGivesNothingIsBegunAnew) {
  Open();
  ASSERT_TRUE(camera_);
  ExpectTaken(0);
  peer_->Device().ForgetStreamTarget();
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  const Result<CapturedPicture> picture = camera_->Collect(0.3, {});
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, ErrorCode::kTimeout);
  ExpectTaken(1);
}

TEST_F(GenicamDevice, ALineTriggersIt) {
  CameraSettings settings = peer_->Settings();
  settings.trigger = CameraTrigger::kHardware;
  Open(settings);
  ASSERT_TRUE(camera_);
  peer_->Arrange(1);
  peer_->Device().Pulse();  // nobody waits for this one
  ASSERT_TRUE(peer_->Await([](const auto& counts) { return counts.shots == 1; }));
  peer_->Arrange(2);
  ASSERT_TRUE(camera_->MakeReady({}));
  ASSERT_TRUE(camera_->Fire());
  peer_->Device().Pulse();
  const Result<CapturedPicture> picture = camera_->Collect(kPicture_s, {});
  ASSERT_TRUE(picture) << picture.error().message;
  EXPECT_TRUE(Same(picture->pixels, peer_->Expected(2)));
}

TEST_F(GenicamDevice, APacketSocketTakesPicturesWhereNoBufferHoldsOne) {
  peer_->Options().most_receive_buffer_bytes = 1000;
  for (int shot = 0; shot < 3; ++shot) {
    Open();  // the first picture after opening is the one that could be missed
    if (!peer_->Told().empty()) GTEST_SKIP() << peer_->Told().front();  // this user may not open a packet socket
    ExpectTaken(shot);
    camera_.reset();
  }
}

TEST_F(GenicamDevice, WhatPicturesNeedToArriveIsTold) {
  peer_->Options().most_receive_buffer_bytes = 1000;
  peer_->Options().packet_socket = false;
  Open();
  ASSERT_EQ(peer_->Told().size(), 1);
  EXPECT_THAT(peer_->Told().front(), HasSubstr("camera 'left': pictures of 76800 bytes may come incomplete"));
  EXPECT_THAT(peer_->Told().front(), HasSubstr("sysctl -w net.core.rmem_max=1000000"));
}

/// Descriptors and threads of this program.
std::pair<std::ptrdiff_t, std::ptrdiff_t> Held() {
  const auto count = [](const char* folder) {
    return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
  };
  return {count("/proc/self/fd"), count("/proc/self/task")};
}

TEST_F(GenicamDevice, ClosedItLeavesNothingBehind) {
  const auto once = [&] {
    Open();
    ExpectTaken(0);
    camera_.reset();
  };
  once();  // what the libraries keep for themselves
  const auto before = Held();
  for (int i = 0; i < 5; ++i) once();
  const auto more = [&] { return Held().first > before.first || Held().second > before.second; };
  const double end_s = peer_->Time().NowS() + GigePeer::kHang_s;  // a thread that has ended stays listed for a moment
  while (more() && peer_->Time().NowS() < end_s) peer_->Time().Wait(0.01, {});
  EXPECT_LE(Held().first, before.first) << "descriptors";
  EXPECT_LE(Held().second, before.second) << "threads";
}

}  // namespace
}  // namespace rigcal
