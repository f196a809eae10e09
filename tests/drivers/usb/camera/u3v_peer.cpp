#include "tests/drivers/usb/camera/u3v_peer.h"

#include <cstdlib>
#include <iostream>
#include <utility>

#include "drivers/genicam/genicam_driver.h"
#include "tests/drivers/usb/emulated/emulated_usb.h"

namespace rigcal {

std::unique_ptr<U3vPeer> U3vPeer::Start(const sim::U3vCameraSpec& spec) {
  const Result<sim::UsbTestbed*> usb = EmulatedUsb();
  if (!usb) {
    std::cerr << usb.error().message << '\n';
    if (std::getenv("RIGCAL_NEEDS_PEERS") != nullptr) ADD_FAILURE() << usb.error().message;
    return nullptr;
  }
  std::unique_ptr<U3vPeer> peer(new U3vPeer(spec, **usb));
  peer->PlugIn();
  return peer;
}

U3vPeer::U3vPeer(const sim::U3vCameraSpec& spec, sim::UsbTestbed& usb) : spec_(spec), usb_(usb) {
  camera_ = std::make_shared<sim::U3vCamera>(
      spec, [this](const sim::U3vShot& shot) { return Pattern(shown_, shot.width_px, shot.height_px); });
}

U3vPeer::~U3vPeer() {
  later_.clear();  // they use the rest
  usb_.UnplugAll();
}

cv::Mat U3vPeer::Pattern(int shot, int width_px, int height_px) {
  cv::Mat picture(height_px, width_px, CV_8U);
  std::uint32_t state = 977u * static_cast<std::uint32_t>(shot) + 1;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      state = state * 1664525u + 1013904223u;
      picture.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(state >> 24);
    }
  }
  return picture;
}

void U3vPeer::After(double seconds, std::function<void()> action) {
  later_.emplace_back([this, seconds, action = std::move(action)](const std::stop_token& stop) {
    if (clock_.Wait(seconds, stop)) action();
  });
}

std::stop_token U3vPeer::StopAfter(double seconds) {
  std::stop_source source;
  After(seconds, [source]() mutable { source.request_stop(); });
  return source.get_token();
}

Result<std::unique_ptr<CameraDevice>> U3vPeer::Open(const CameraSettings& settings) {
  GenicamOptions options;
  options.reach = GigeReach::kThisMachine;  // it is looked for on the networks when it is not plugged in
  return MakeGenicamDriver(options, {.clock = &clock_})->OpenCamera(settings, {});
}

void U3vPeer::PlugIn(const std::string& port_path) {
  PlugIn(PlugOf(spec_, port_path));
}

void U3vPeer::PlugIn(const sim::UsbPlug& plug) {
  const std::lock_guard lock(mutex_);
  const Result<void> plugged = usb_.Plug(plug, camera_);
  EXPECT_TRUE(plugged) << plugged.error().message;
}

void U3vPeer::Unplug() {
  const std::lock_guard lock(mutex_);
  usb_.UnplugAll();
}

void U3vPeer::Set(CameraFault fault, bool on) {
  sim::U3vFaults faults = camera_->Faults();
  if (fault == CameraFault::kSilent) faults.silent = on;
  if (fault == CameraFault::kDamaged) faults.truncated = on;
  if (fault == CameraFault::kHeldByOther) faults.held = on;
  camera_->Set(faults);
  if (fault == CameraFault::kGone && on) Unplug();
  if (fault == CameraFault::kGone && !on) PlugIn();
}

void U3vPeer::GoneFor(double seconds) {
  Unplug();
  After(seconds, [this] { PlugIn(); });
}

}  // namespace rigcal
