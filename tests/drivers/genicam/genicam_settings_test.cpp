#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "drivers/genicam/genicam_driver.h"
#include "tests/drivers/genicam/genicam_device.h"

namespace rigcal {
namespace {

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

}  // namespace
}  // namespace rigcal
