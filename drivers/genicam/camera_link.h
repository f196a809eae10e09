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

/// A camera that this program controls: found, opened, nobody else's. Errors name the camera of the rig.
class CameraLink {
 public:
  /// Finds the camera by its address, or by its serial number, and takes the control of it. Errors: kNotFound (nothing
  /// answers, or another camera does), kDevice (somebody else controls it: who; it cannot be opened), kBadInput,
  /// kCancelled.
  static Result<std::unique_ptr<CameraLink>> Open(const CameraSettings& settings, const GenicamOptions& options,
                                                  Clock& clock, const std::stop_token& stop);
  /// Gives the control back. Takes twice 3 s when the camera does not answer: Aravis waits for it, and nothing ends
  /// that.
  ~CameraLink();
  CameraLink(const CameraLink&) = delete;
  CameraLink& operator=(const CameraLink&) = delete;

  [[nodiscard]] ArvCamera* Camera() const { return camera_.get(); }
  [[nodiscard]] const GigeAnswer& Announced() const { return announced_; }

  /// Whether something answers at its address that says to be this camera.
  [[nodiscard]] bool Answers(const std::stop_token& stop) const;
  /// Whether the camera answers and is still ours. Errors: kDevice: why not; kCancelled.
  [[nodiscard]] Result<void> Check(const std::stop_token& stop) const;
  /// Whether it said that it has another controller, or none, or has not answered for some seconds.
  [[nodiscard]] bool ControlLost() const { return *control_lost_; }

 private:
  CameraLink(const std::string& id, GigeAnswer announced, const GenicamOptions& options, Clock& clock,
             GObjectPointer<ArvCamera> camera);

  std::string id_;
  GigeAnswer announced_;
  double answer_s_;
  Clock& clock_;
  GObjectPointer<ArvCamera> camera_;
  std::shared_ptr<std::atomic<bool>> control_lost_;  ///< shared with Aravis' heartbeat, which may be a step behind
  gulong handler_ = 0;
};

}  // namespace rigcal
