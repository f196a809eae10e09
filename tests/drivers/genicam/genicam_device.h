#pragma once

#include <gmock/gmock.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tests/drivers/genicam/gige_peer.h"

namespace rigcal {

inline constexpr double kPicture_s = GigePeer::kHang_s;

/// Whether two pictures are the same byte for byte.
inline bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && std::memcmp(a.ptr(), b.ptr(), a.total() * a.elemSize()) == 0;
}

/// The driver with a simulated camera, and what its tests do again and again.
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
  Result<CapturedPicture> Take(int shot, double timeout_s = kPicture_s) {
    if (!camera_) return Fail(ErrorCode::kDevice, "it could not be opened");
    peer_->Arrange(shot);
    if (Result<void> ready = camera_->MakeReady({}); !ready) return Fail(ready.error());
    if (Result<void> fired = camera_->Fire(); !fired) return Fail(fired.error());
    return camera_->Collect(timeout_s, {});
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
    EXPECT_THAT(opened.error().message, ::testing::HasSubstr("camera 'left'"));
    for (const std::string& part : parts) EXPECT_THAT(opened.error().message, ::testing::HasSubstr(part));
  }

  std::unique_ptr<GigePeer> peer_;
  std::unique_ptr<CameraDevice> camera_;
};

}  // namespace rigcal
