#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/clock.h"
#include "core/scene/rig_devices.h"
#include "drivers/camera_device.h"
#include "drivers/genicam/camera_link.h"
#include "drivers/genicam/camera_setup.h"
#include "drivers/genicam/decode_picture.h"
#include "drivers/genicam/frame_stream.h"
#include "drivers/genicam/genicam_options.h"

namespace rigcal {

/// A GenICam camera. Acquisition runs all the time; a picture is of this shot when the camera's clock says that it was
/// taken after MakeReady. Exposure, gain and temperature are asked for with each picture.
class GenicamCamera final : public CameraDevice {
 public:
  /// Finds, opens and sets it. `tell` gets what is wrong with the way its pictures take. The clock outlives it. Errors:
  /// those of CameraLink::Open and SetUpCamera.
  static Result<std::unique_ptr<CameraDevice>> Open(const CameraSettings& settings, const GenicamOptions& options,
                                                    const std::function<void(const std::string&)>& tell, Clock& clock,
                                                    const std::stop_token& stop);
  ~GenicamCamera() override;

  [[nodiscard]] const RecordedCamera& Identity() const override { return identity_; }
  [[nodiscard]] bool Linear() const override { return facts_.linear; }
  Result<void> MakeReady(const std::stop_token& stop) override;
  Result<void> Fire() override;
  Result<CapturedPicture> Collect(double timeout_s, const std::stop_token& stop) override;
  Result<void> Restore(double timeout_s, const std::stop_token& stop) override;

 private:
  GenicamCamera(const CameraSettings& settings, const GenicamOptions& options, const PixelLayout& layout, Clock& clock);
  /// Opens, sets and starts it.
  Result<void> Connect(const std::stop_token& stop);
  void Disconnect();
  Result<void> StartStream(const std::stop_token& stop);
  /// Ends the stream and begins another one, when nothing of an earlier shot can be on its way any more.
  Result<void> RestartStream(const std::stop_token& stop);
  /// The camera's clock now; 0 where it has none.
  Result<std::uint64_t> CameraTime_ns();
  /// What is known of a frame that came: this shot's picture, nothing for one of an earlier shot, or the flaw.
  Result<std::optional<CapturedPicture>> Judge(const ReceivedFrame& frame);
  void ReadBack(CapturedPicture& picture);
  [[nodiscard]] tl::unexpected<Error> Stopped(const char* what) const;

  CameraSettings settings_;
  GenicamOptions options_;
  PixelLayout layout_;
  Clock& clock_;
  RecordedCamera identity_;
  std::unique_ptr<CameraLink> link_;  ///< none while it is lost
  CameraFacts facts_;
  ReceivePath path_;
  std::unique_ptr<FrameStream> stream_;  ///< of link_
  bool awaited_ = false;                 ///< a shot whose picture has not come
  bool stalled_ = false;                 ///< a picture did not come in time: the stream is begun anew
  std::uint64_t ready_ns_ = 0;           ///< the camera's time when it was made ready last
  std::uint64_t number_ = 0;             ///< of the last picture, whole or not
  int num_incomplete_ = 0;
};

}  // namespace rigcal
