#include "drivers/sim/sim_camera.h"

#include <algorithm>
#include <utility>

namespace rigcal {
namespace {

constexpr double kFirstPause_s = 0.1, kLongestPause_s = 1;  ///< between two tries to connect

std::optional<int> BitsOf(const std::string& pixel_format) {
  if (pixel_format == "Mono8") return 8;
  if (pixel_format == "Mono10" || pixel_format == "Mono12" || pixel_format == "Mono16") return 16;
  return std::nullopt;
}

}  // namespace

Result<std::unique_ptr<CameraDevice>> SimCamera::Open(std::shared_ptr<SimRig> rig, int camera,
                                                      const CameraSettings& settings) {
  const std::optional<int> bits = BitsOf(settings.pixel_format);
  if (!bits) {
    return Fail(ErrorCode::kUnsupported, "camera '{}': a simulated one has no pixel format {}, only Mono8, 10, 12, 16",
                settings.id, settings.pixel_format);
  }
  if (settings.region) {
    return Fail(ErrorCode::kUnsupported, "camera '{}': a simulated one has no region", settings.id);
  }
  const int num_cameras = static_cast<int>(rig->Content().truth.cameras.size());
  if (camera >= num_cameras) {
    return Fail(ErrorCode::kNotFound, "camera '{}': is number {} of the driver sim, the studio has {}", settings.id,
                camera + 1, num_cameras);
  }
  if (rig->Faults(camera).gone) return Fail(ErrorCode::kDevice, "camera '{}': does not answer", settings.id);
  if (!rig->Hold(camera)) return Fail(ErrorCode::kDevice, "camera '{}': somebody else holds it", settings.id);
  return std::unique_ptr<CameraDevice>(new SimCamera(std::move(rig), camera, settings, *bits));
}

SimCamera::SimCamera(std::shared_ptr<SimRig> rig, int camera, const CameraSettings& settings, int bits)
    : rig_(std::move(rig)),
      camera_(camera),
      bits_(bits),
      exposure_us_(settings.exposure_us),
      gain_db_(settings.gain_db) {
  const Camera& truth = rig_->Content().truth.cameras[camera];
  identity_ = {.id = settings.id,
               .width_px = truth.width_px,
               .height_px = truth.height_px,
               .serial = settings.serial,
               .model = "rigcal simulated camera",
               .lens = settings.lens,
               .pixel_format = settings.pixel_format,
               .focus_m = settings.focus_m};
}

SimCamera::~SimCamera() {
  rig_->Free(camera_);
}

tl::unexpected<Error> SimCamera::Stopped(const char* what) const {
  return Fail(ErrorCode::kCancelled, "camera '{}': {} was stopped on request", identity_.id, what);
}

Result<void> SimCamera::CheckConnected() {
  if (rig_->Faults(camera_).gone) connected_ = false;
  if (connected_) return {};
  fired_.reset();
  return Fail(ErrorCode::kDevice, "camera '{}': the connection is lost", identity_.id);
}

Result<void> SimCamera::MakeReady(const std::stop_token& stop) {
  fired_.reset();
  if (stop.stop_requested()) return Stopped("making it ready");
  return CheckConnected();
}

Result<void> SimCamera::Fire() {
  if (Result<void> connected = CheckConnected(); !connected) return connected;
  const double angle_rad = rig_->Table().Angle();
  fired_ = Shot{angle_rad, num_shots_by_angle_rad_[angle_rad]++};
  ++number_;
  return {};
}

Result<CapturedPicture> SimCamera::Collect(double timeout_s, const std::stop_token& stop) {
  if (Result<void> connected = CheckConnected(); !connected) return Fail(connected.error());
  const SimCameraFaults faults = rig_->Faults(camera_);
  const std::optional<Shot> shot = std::exchange(fired_, std::nullopt);
  if (!shot || faults.silent) {
    if (!rig_->Time().Wait(timeout_s, stop)) return Stopped("waiting for the picture");
    return Fail(ErrorCode::kTimeout, "camera '{}': no picture within {:.1f} s", identity_.id, timeout_s);
  }
  if (faults.damaged) return Fail(ErrorCode::kDevice, "camera '{}': picture {} came incomplete", identity_.id, number_);
  if (!faults.frozen || last_picture_.empty()) {
    Result<cv::Mat> picture = rig_->Picture(camera_, shot->angle_rad, shot->attempt, bits_, stop);
    if (!picture) return stop.stop_requested() ? Stopped("taking the picture") : Fail(picture.error());
    if (faults.blinded) picture->setTo(cv::Scalar::all(bits_ == 8 ? 255 : 65535));
    last_picture_ = *picture;
  }
  return CapturedPicture{
      .pixels = last_picture_.clone(), .number = number_, .exposure_us = exposure_us_, .gain_db = gain_db_};
}

Result<void> SimCamera::Restore(double timeout_s, const std::stop_token& stop) {
  const double end_s = rig_->Time().NowS() + timeout_s;
  double pause_s = kFirstPause_s;
  while (!stop.stop_requested()) {
    if (!rig_->Faults(camera_).gone) {
      connected_ = true;
      return {};
    }
    connected_ = false;
    fired_.reset();
    const double left_s = end_s - rig_->Time().NowS();
    if (left_s <= 0) {
      return Fail(ErrorCode::kDevice, "camera '{}': did not come back within {:.1f} s: it does not answer",
                  identity_.id, timeout_s);
    }
    rig_->Time().Wait(std::min(pause_s, left_s), stop);
    pause_s = std::min(2 * pause_s, kLongestPause_s);
  }
  return Stopped("connecting again");
}

}  // namespace rigcal
