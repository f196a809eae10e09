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
#include "sim_fixtures/gige/gige_device.h"
#include "tests/drivers/camera_contract.h"

namespace rigcal {

/// A simulated GigE Vision camera before the driver, in real time. It shows a test pattern that goes by the number of
/// the shot that was arranged last.
class GigePeer final : public CameraPeer {
 public:
  static constexpr int kWidth_px = 320, kHeight_px = 240;
  static constexpr double kHang_s = 60;  ///< real time beyond which a wait that should have ended hangs

  /// Nothing where it cannot run; why, goes to stderr, and with RIGCAL_NEEDS_PEERS set that is a failure.
  static std::unique_ptr<GigePeer> Start(sim::GigeDeviceOptions options = {});
  ~GigePeer() override;

  Clock& Time() override { return clock_; }
  /// What is to end in time is on a machine that may be busy with anything.
  double SlackS() const override { return kHang_s; }
  std::stop_token StopAfter(double seconds) override;
  CameraSettings Settings() override;
  Result<std::unique_ptr<CameraDevice>> Open() override { return Open(Settings()); }
  Result<std::unique_ptr<CameraDevice>> Open(const CameraSettings& settings);
  void Arrange(int shot) override { shown_ = shot; }
  cv::Mat Expected(int shot) override { return Pattern(shot, kWidth_px, kHeight_px, 8); }

  std::optional<std::string> WhyNot(CameraFault fault) override;
  void Set(CameraFault fault, bool on) override;
  void GoneFor(double seconds) override;

  /// What the sensor has for a shot: CV_8U, or CV_16U with values of so many bits.
  static cv::Mat Pattern(int shot, int width_px, int height_px, int bits);
  /// Shows something else from now on.
  void Show(sim::GigePictureSource source);

  sim::GigeDevice& Device() { return *device_; }
  GenicamOptions& Options() { return options_; }
  std::vector<std::string>& Told() { return told_; }
  /// Changes the faults of the device.
  void Fault(const std::function<void(sim::GigeFaults&)>& change);
  /// Waits until the device's counts are as wanted; false when that hangs.
  bool Await(const std::function<bool(const sim::GigeCounts&)>& wanted);

 private:
  GigePeer();
  /// Does something later, unless the peer goes first.
  void After(double seconds, std::function<void()> action);

  SystemClock clock_;
  GenicamOptions options_;
  std::atomic<int> shown_ = 0;
  std::mutex mutex_;
  sim::GigePictureSource source_;  ///< guarded by mutex_
  std::unique_ptr<sim::GigeDevice> device_;
  std::unique_ptr<CameraDevice> other_;
  std::vector<std::string> told_;
  std::vector<std::jthread> later_;
};

}  // namespace rigcal
