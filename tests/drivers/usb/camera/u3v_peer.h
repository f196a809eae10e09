#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <string>
#include <thread>
#include <vector>

#include "drivers/genicam/genicam_options.h"
#include "sim_fixtures/u3v/u3v_camera.h"
#include "sim_fixtures/u3v/usb_testbed.h"
#include "tests/drivers/camera_contract.h"

namespace rigcal {

/// An emulated USB3 Vision camera before the driver, in real time. It shows a test pattern that goes by the number of
/// the shot that was arranged last.
class U3vPeer final : public CameraPeer {
 public:
  static constexpr double kHang_s = 60;  ///< real time beyond which a wait that should have ended hangs

  /// Nothing where USB cannot be emulated (with RIGCAL_NEEDS_PEERS set that is a failure).
  static std::unique_ptr<U3vPeer> Start(const sim::U3vCameraSpec& spec = Small());
  static sim::U3vCameraSpec Small() { return {.serial = "U3V7", .width_px = 320, .height_px = 240}; }
  ~U3vPeer() override;

  Clock& Time() override { return clock_; }
  double SlackS() const override { return kHang_s; }  ///< on a machine that may be busy with anything
  std::stop_token StopAfter(double seconds) override;
  CameraSettings Settings() override { return {.id = "top", .driver = "genicam", .serial = spec_.serial}; }
  Result<std::unique_ptr<CameraDevice>> Open() override { return Open(Settings()); }
  Result<std::unique_ptr<CameraDevice>> Open(const CameraSettings& settings);
  void Arrange(int shot) override { shown_ = shot; }
  cv::Mat Expected(int shot) override { return Pattern(shot, spec_.width_px, spec_.height_px); }

  std::optional<std::string> WhyNot(CameraFault /*fault*/) override { return std::nullopt; }
  void Set(CameraFault fault, bool on) override;
  void GoneFor(double seconds) override;

  /// Every byte says of which shot it is. CV_8U.
  static cv::Mat Pattern(int shot, int width_px, int height_px);

  sim::U3vCamera& Camera() { return *camera_; }
  void PlugIn(const std::string& port_path = "1-1");
  void PlugIn(const sim::UsbPlug& plug);
  void Unplug();

 private:
  U3vPeer(const sim::U3vCameraSpec& spec, sim::UsbTestbed& usb);
  /// Does something later, unless the peer goes first.
  void After(double seconds, std::function<void()> action);

  SystemClock clock_;
  sim::U3vCameraSpec spec_;
  std::atomic<int> shown_ = 0;
  std::shared_ptr<sim::U3vCamera> camera_;
  std::mutex mutex_;  ///< guards what follows
  sim::UsbTestbed& usb_;
  std::vector<std::jthread> later_;
};

}  // namespace rigcal
