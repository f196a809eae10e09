#include <filesystem>

#include "tests/drivers/genicam/genicam_device.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

constexpr sim::GigeEndpoint kElsewhere{0x0a010203, 4711};  // 10.1.2.3
constexpr sim::GigeEndpoint kThisMachine{0x7f000001, 4711};

INSTANTIATE_TEST_SUITE_P(Genicam, CameraContract,
                         ::testing::Values([] { return std::unique_ptr<CameraPeer>(GigePeer::Start()); }));

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

// With several programs at packet sockets of one interface, one in twenty of the first pictures after opening does not
// come, or comes incomplete (README.md): taken again, as acquisition does.
TEST_F(GenicamDevice, APacketSocketTakesPicturesWhereNoBufferHoldsOne) {
  constexpr int kAttempts = 5;
  constexpr double kAttempt_s = 5;
  peer_->Options().most_receive_buffer_bytes = 1000;
  for (int shot = 0; shot < 3; ++shot) {
    Open();
    if (!peer_->Told().empty()) GTEST_SKIP() << peer_->Told().front();  // this user may not open a packet socket
    Result<CapturedPicture> picture = Take(shot, kAttempt_s);
    for (int attempt = 1; !picture && attempt < kAttempts; ++attempt) picture = Take(shot, kAttempt_s);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_TRUE(Same(picture->pixels, peer_->Expected(shot))) << "shot " << shot;
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
