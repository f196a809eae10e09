#pragma once

#include <atomic>
#include <memory>
#include <stop_token>
#include <string>

#include "core/base/clock.h"
#include "core/base/result.h"
#include "core/scene/rig_devices.h"
#include "drivers/genicam/genicam_options.h"
#include "drivers/genicam/gobject_pointer.h"

namespace rigcal {

/// What a camera said of itself before it was opened.
struct AnnouncedCamera {
  std::string address;  ///< IPv4, or the port path of a USB camera
  std::string vendor, model, serial;
};

/// A camera that this program controls: found, opened, nobody else's. Errors name the camera of the rig.
class CameraLink {
 public:
  /// Finds the camera by its address, or by its serial number (first on USB, where looking costs nothing, then on the
  /// networks), and takes the control of it. Errors: kNotFound (nothing answers, or another camera does), kDevice
  /// (somebody else controls it: who; it cannot be opened), kBadInput, kCancelled.
  static Result<std::unique_ptr<CameraLink>> Open(const CameraSettings& settings, const GenicamOptions& options,
                                                  Clock& clock, const std::stop_token& stop);
  /// Gives the control back.
  virtual ~CameraLink();
  CameraLink(const CameraLink&) = delete;
  CameraLink& operator=(const CameraLink&) = delete;

  [[nodiscard]] ArvCamera* Camera() const { return camera_.get(); }
  [[nodiscard]] const AnnouncedCamera& Announced() const { return announced_; }

  /// Whether the camera answers and is still ours. Errors: kDevice: why not; kCancelled.
  [[nodiscard]] virtual Result<void> Check(const std::stop_token& stop) const = 0;
  /// Whether closing it now would take seconds, because Aravis waits for answers that do not come.
  [[nodiscard]] virtual bool ClosesLate() const = 0;
  /// Whether it said that it has another controller, or none, has not answered for some seconds, or was unplugged.
  [[nodiscard]] bool ControlLost() const { return *control_lost_; }

 protected:
  CameraLink(const std::string& id, AnnouncedCamera announced, GObjectPointer<ArvCamera> camera);
  [[nodiscard]] const std::string& Id() const { return id_; }

 private:
  std::string id_;
  AnnouncedCamera announced_;
  GObjectPointer<ArvCamera> camera_;
  std::shared_ptr<std::atomic<bool>> control_lost_;  ///< shared with Aravis' threads, which may be a step behind
  gulong handler_ = 0;
};

}  // namespace rigcal
