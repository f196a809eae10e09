#pragma once

#include <memory>
#include <string>

#include "drivers/genicam/camera_link.h"

namespace rigcal {

/// A USB3 Vision camera.
class UsbLink final : public CameraLink {
 public:
  /// Whether the settings' address is a port path ("1-2.3"), or they have none and a USB camera with their serial
  /// number is plugged in.
  static bool Means(const CameraSettings& settings);

  /// Opens it, if no malformed device is plugged in on which Aravis would crash. Errors: kNotFound (it is not plugged
  /// in), kBadInput (two with this serial number), kDevice (malformed descriptors, no right to open it, held by another
  /// program).
  static Result<std::unique_ptr<CameraLink>> Open(const CameraSettings& settings);

  [[nodiscard]] Result<void> Check(const std::stop_token& stop) const override;
  [[nodiscard]] bool ClosesLate() const override { return false; }  // transfers to a lost device end at once

 private:
  UsbLink(const std::string& id, AnnouncedCamera announced, GObjectPointer<ArvCamera> camera)
      : CameraLink(id, std::move(announced), std::move(camera)) {}
};

}  // namespace rigcal
