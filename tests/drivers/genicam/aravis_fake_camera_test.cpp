#include <arv.h>

#include "drivers/genicam/genicam_driver.h"
#include "drivers/genicam/gobject_pointer.h"
#include "tests/drivers/genicam/genicam_device.h"

namespace rigcal {
namespace {

constexpr const char* kAddress = "127.0.0.1";  // it wants an address that an interface has
constexpr const char* kSerial = "SIM-ARAVIS";
constexpr double kTriggerPoll_hz = 1000;

/// A GigE Vision camera that somebody else wrote: Aravis has one for tests of its own. It sends nothing again, and
/// there is room for one on this machine.
TEST(AravisFakeCamera, PicturesOfAnIndependentPeerArrive) {
  const GObjectPointer<ArvGvFakeCamera> peer(arv_gv_fake_camera_new(kAddress, kSerial));
  if (arv_gv_fake_camera_is_running(peer.get()) == FALSE) GTEST_SKIP() << kAddress << ":3956 is taken";
  ArvFakeCamera* camera_of = arv_gv_fake_camera_get_fake_camera(peer.get());
  arv_fake_camera_set_trigger_frequency(camera_of, kTriggerPoll_hz);
  SystemClock clock;
  const CameraSettings settings{.id = "left", .driver = "genicam", .address = kAddress, .exposure_us = 2000};
  auto camera = MakeGenicamDriver(GenicamOptions{}, {.clock = &clock})->OpenCamera(settings, {});
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_EQ((*camera)->Identity().serial, kSerial);
  int num_pictures = 0;
  for (int shot = 0; shot < 20 && num_pictures < 3; ++shot) {
    ASSERT_TRUE((*camera)->MakeReady({}));
    ASSERT_TRUE((*camera)->Fire());
    const Result<CapturedPicture> picture = (*camera)->Collect(kPicture_s, {});
    if (!picture && picture.error().code == ErrorCode::kDevice) continue;  // a packet was lost: it is taken again
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->pixels.size(), cv::Size((*camera)->Identity().width_px, (*camera)->Identity().height_px));
    double least = 0, most = 0;
    cv::minMaxLoc(picture->pixels, &least, &most);
    EXPECT_GT(most, least);
    EXPECT_NEAR(*picture->exposure_us, 2000, 1);
    ++num_pictures;
  }
  EXPECT_EQ(num_pictures, 3);
}

}  // namespace
}  // namespace rigcal
