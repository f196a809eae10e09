#include "tests/drivers/camera_contract.h"

#include <gmock/gmock.h>

#include <limits>

#include "drivers/acquire/same_bytes.h"

namespace rigcal {

using ::testing::HasSubstr;

namespace {

constexpr double kPicture_s = 20;  ///< in real time a bound for hangs only: what comes, comes long before
constexpr double kShort_s = 0.5;   ///< a wait that is meant to end without its event
constexpr double kRestore_s = 20;
constexpr double kOuttime_s = 3;  ///< how long a camera is gone that comes back: issue 4, point 3

template <typename T>
std::string MessageOf(const Result<T>& result) {
  return result ? "no error" : result.error().message;
}

}  // namespace

#define SKIP_WITHOUT(fault) \
  if (const auto why = peer_->WhyNot(fault)) GTEST_SKIP() << *why

void CameraContract::SetUp() {
  peer_ = GetParam()();
  if (!peer_) GTEST_SKIP() << "its peer cannot run here";
}

std::unique_ptr<CameraDevice> CameraContract::Open() {
  Result<std::unique_ptr<CameraDevice>> camera = peer_->Open();
  EXPECT_TRUE(camera) << MessageOf(camera);
  return camera ? std::move(*camera) : nullptr;
}

Result<void> CameraContract::Shoot(CameraDevice& camera, int shot) {
  peer_->Arrange(shot);
  if (Result<void> ready = camera.MakeReady({}); !ready) return ready;
  return camera.Fire();
}

void CameraContract::ExpectCollected(CameraDevice& camera, int shot) {
  const Result<CapturedPicture> picture = camera.Collect(kPicture_s, {});
  ASSERT_TRUE(picture) << MessageOf(picture);
  EXPECT_TRUE(SameBytes(picture->pixels, peer_->Expected(shot))) << "shot " << shot;
  EXPECT_EQ(picture->pixels.size(), cv::Size(camera.Identity().width_px, camera.Identity().height_px));
  EXPECT_TRUE(!any_picture_ || picture->number > last_number_) << picture->number << " after " << last_number_;
  any_picture_ = true;
  last_number_ = picture->number;
}

void CameraContract::ExpectPicture(CameraDevice& camera, int shot) {
  const Result<void> fired = Shoot(camera, shot);
  ASSERT_TRUE(fired) << MessageOf(fired);
  ExpectCollected(camera, shot);
}

TEST_P(CameraContract, SaysWhoItIs) {
  const auto camera = Open();
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->Identity().id, peer_->Settings().id);
  EXPECT_GT(camera->Identity().width_px, 0);
  EXPECT_GT(camera->Identity().height_px, 0);
  if (!peer_->Settings().serial.empty()) {
    EXPECT_EQ(camera->Identity().serial, peer_->Settings().serial);
  }
}

TEST_P(CameraContract, EachShotHasItsOwnPictureByteForByte) {
  const auto camera = Open();
  ASSERT_TRUE(camera);
  for (int shot = 0; shot < 3; ++shot) ExpectPicture(*camera, shot);
  EXPECT_FALSE(SameBytes(peer_->Expected(0), peer_->Expected(1))) << "the peer's shots must differ to show anything";
}

TEST_P(CameraContract, APictureThatNobodyCollectedIsNotTheNextOne) {
  const auto camera = Open();
  ASSERT_TRUE(camera);
  ASSERT_TRUE(Shoot(*camera, 0));
  ExpectPicture(*camera, 1);
}

TEST_P(CameraContract, WithoutAShotThereIsNoPicture) {
  const auto camera = Open();
  ASSERT_TRUE(camera);
  ASSERT_TRUE(Shoot(*camera, 0));  // given up by the next line
  ASSERT_TRUE(camera->MakeReady({}));
  const double begin_s = peer_->Time().NowS();
  const Result<CapturedPicture> picture = camera->Collect(kShort_s, {});
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, ErrorCode::kTimeout) << MessageOf(picture);
  EXPECT_GE(peer_->Time().NowS() - begin_s, kShort_s - 1e-6);
}

TEST_P(CameraContract, WaitsNoLongerThanTold) {
  SKIP_WITHOUT(CameraFault::kSilent);
  const auto camera = Open();
  ASSERT_TRUE(camera);
  peer_->Set(CameraFault::kSilent, true);
  ASSERT_TRUE(Shoot(*camera, 0));
  const double begin_s = peer_->Time().NowS();
  const Result<CapturedPicture> picture = camera->Collect(kShort_s, {});
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, ErrorCode::kTimeout);
  EXPECT_THAT(picture.error().message, HasSubstr(peer_->Settings().id));
  EXPECT_GE(peer_->Time().NowS() - begin_s, kShort_s - 1e-6);
  EXPECT_LE(peer_->Time().NowS() - begin_s, kShort_s + 1e-6 + peer_->SlackS());
  peer_->Set(CameraFault::kSilent, false);
  ExpectPicture(*camera, 1);
}

TEST_P(CameraContract, StopsWaitingOnRequest) {
  SKIP_WITHOUT(CameraFault::kSilent);
  const auto camera = Open();
  ASSERT_TRUE(camera);
  peer_->Set(CameraFault::kSilent, true);
  ASSERT_TRUE(Shoot(*camera, 0));
  constexpr double kHour_s = 3600;
  const double begin_s = peer_->Time().NowS();
  const Result<CapturedPicture> picture = camera->Collect(kHour_s, peer_->StopAfter(kShort_s));
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, ErrorCode::kCancelled) << MessageOf(picture);
  EXPECT_LE(peer_->Time().NowS() - begin_s, kShort_s + 1e-6 + peer_->SlackS());
}

TEST_P(CameraContract, ADamagedPictureIsNeverHandedOut) {
  SKIP_WITHOUT(CameraFault::kDamaged);
  const auto camera = Open();
  ASSERT_TRUE(camera);
  peer_->Set(CameraFault::kDamaged, true);
  ASSERT_TRUE(Shoot(*camera, 0));
  const Result<CapturedPicture> picture = camera->Collect(kPicture_s, {});
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().code, ErrorCode::kDevice) << MessageOf(picture);
  EXPECT_THAT(picture.error().message, HasSubstr(peer_->Settings().id));
  peer_->Set(CameraFault::kDamaged, false);
  ExpectPicture(*camera, 1);
}

TEST_P(CameraContract, RestoreLeavesAWellCameraAlone) {
  const auto camera = Open();
  ASSERT_TRUE(camera);
  ASSERT_TRUE(Shoot(*camera, 0));
  const Result<void> restored = camera->Restore(kRestore_s, {});
  ASSERT_TRUE(restored) << MessageOf(restored);
  ExpectCollected(*camera, 0);
}

TEST_P(CameraContract, ComesBackAfterItWasGone) {
  SKIP_WITHOUT(CameraFault::kGone);
  const auto camera = Open();
  ASSERT_TRUE(camera);
  ExpectPicture(*camera, 0);
  peer_->GoneFor(kOuttime_s);
  if (Shoot(*camera, 1)) {
    EXPECT_FALSE(camera->Collect(kShort_s, {}));
  }
  const Result<void> restored = camera->Restore(kRestore_s, {});
  ASSERT_TRUE(restored) << MessageOf(restored);
  ExpectPicture(*camera, 2);
}

TEST_P(CameraContract, GivesUpOnOneThatStaysAwayAndNamesIt) {
  SKIP_WITHOUT(CameraFault::kGone);
  const auto camera = Open();
  ASSERT_TRUE(camera);
  peer_->Set(CameraFault::kGone, true);
  if (Shoot(*camera, 0)) {
    EXPECT_FALSE(camera->Collect(kShort_s, {}));
  }
  const double begin_s = peer_->Time().NowS();
  const Result<void> restored = camera->Restore(kOuttime_s, {});
  ASSERT_FALSE(restored);
  EXPECT_EQ(restored.error().code, ErrorCode::kDevice);
  EXPECT_THAT(restored.error().message, HasSubstr(peer_->Settings().id));
  EXPECT_LE(peer_->Time().NowS() - begin_s, kOuttime_s + 1e-6 + peer_->SlackS());
}

TEST_P(CameraContract, RestoreStopsOnRequest) {
  SKIP_WITHOUT(CameraFault::kGone);
  const auto camera = Open();
  ASSERT_TRUE(camera);
  peer_->Set(CameraFault::kGone, true);
  if (Shoot(*camera, 0)) {
    EXPECT_FALSE(camera->Collect(kShort_s, {}));
  }
  constexpr double kHour_s = 3600;
  const double begin_s = peer_->Time().NowS();
  const Result<void> restored = camera->Restore(kHour_s, peer_->StopAfter(kShort_s));
  ASSERT_FALSE(restored);
  EXPECT_EQ(restored.error().code, ErrorCode::kCancelled) << MessageOf(restored);
  EXPECT_LE(peer_->Time().NowS() - begin_s, kShort_s + 1e-6 + peer_->SlackS());
}

TEST_P(CameraContract, OneThatIsNotThereIsNotOpened) {
  SKIP_WITHOUT(CameraFault::kGone);
  peer_->Set(CameraFault::kGone, true);
  const Result<std::unique_ptr<CameraDevice>> camera = peer_->Open();
  ASSERT_FALSE(camera);
  EXPECT_THAT(camera.error().message, HasSubstr(peer_->Settings().id));
}

TEST_P(CameraContract, OneThatSomebodyElseHoldsIsRefusedByName) {
  SKIP_WITHOUT(CameraFault::kHeldByOther);
  peer_->Set(CameraFault::kHeldByOther, true);
  const Result<std::unique_ptr<CameraDevice>> camera = peer_->Open();
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error().code, ErrorCode::kDevice);
  EXPECT_THAT(camera.error().message, HasSubstr(peer_->Settings().id));
}

TEST_P(CameraContract, IsFreeForOthersOnceClosed) {
  auto camera = Open();
  ASSERT_TRUE(camera);
  ExpectPicture(*camera, 0);
  camera.reset();
  any_picture_ = false;  // pictures are counted from opening
  camera = Open();
  ASSERT_TRUE(camera);
  ExpectPicture(*camera, 1);
}

}  // namespace rigcal
