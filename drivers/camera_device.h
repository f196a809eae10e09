#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <stop_token>
#include <string>

#include "core/base/result.h"
#include "core/scene/recording.h"

namespace rigcal {

/// A picture's file where there is one already.
struct PictureFile {
  std::string name;   ///< relative to its recording's folder
  std::string bytes;  ///< as it is encoded
};

/// One picture as a camera gave it: whole, or it would be an Error.
struct CapturedPicture {
  cv::Mat pixels;  ///< CV_8U or CV_16U at full scale of its depth; 1 channel, or 3 (BGR)
  /// Counts the camera's pictures since it was opened; two pictures never share one.
  std::uint64_t number = 0;
  std::optional<double> exposure_us, gain_db, temperature_celsius;
  std::optional<std::string> taken_at;  ///< ISO 8601, UTC, where the device knows better than the machine's clock
  std::optional<PictureFile> file;      ///< kept as it is instead of being encoded anew (replay)
};

/// One physical camera, opened and set as its CameraSettings say. Used by one thread. Closed when destroyed, and free
/// for others then. Every Error names the camera. Codes: kDevice (the camera failed; Restore may help), kTimeout,
/// kCancelled.
class CameraDevice {
 public:
  virtual ~CameraDevice() = default;
  CameraDevice() = default;
  CameraDevice(const CameraDevice&) = delete;
  CameraDevice& operator=(const CameraDevice&) = delete;

  /// As a recording names it: id, size, and what the device tells of itself.
  [[nodiscard]] virtual const RecordedCamera& Identity() const = 0;

  /// Whether its pixel values are proportional to the light, as they are unless a camera's gamma is on.
  [[nodiscard]] virtual bool Linear() const { return true; }

  /// Forgets every picture that is still under way and makes the camera ready for one shot; a picture that was
  /// triggered before is never taken for the next one.
  virtual Result<void> MakeReady(const std::stop_token& stop) = 0;

  /// Takes the picture (software trigger); returns without waiting for it. With a hardware trigger it does nothing.
  virtual Result<void> Fire() = 0;

  /// The picture of this shot; one that has come already is given whatever timeout_s. Errors: kTimeout after timeout_s;
  /// kDevice: connection lost, or the picture came incomplete (it is dropped, never handed out).
  virtual Result<CapturedPicture> Collect(double timeout_s, const std::stop_token& stop) = 0;

  /// Brings back a camera that failed: connects again with growing pauses for up to timeout_s. Leaves one that is well
  /// alone. Errors: kDevice with the last reason.
  virtual Result<void> Restore(double timeout_s, const std::stop_token& stop) = 0;
};

}  // namespace rigcal
