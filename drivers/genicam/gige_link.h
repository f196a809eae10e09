#pragma once

#include <memory>
#include <string>

#include "drivers/genicam/camera_link.h"

namespace rigcal {

/// A GigE Vision camera. Closing one that does not answer takes twice 3 s: Aravis waits for it, and nothing ends that.
class GigeLink final : public CameraLink {
 public:
  /// See CameraLink::Open.
  static Result<std::unique_ptr<CameraLink>> Open(const CameraSettings& settings, const GenicamOptions& options,
                                                  Clock& clock, const std::stop_token& stop);

  [[nodiscard]] Result<void> Check(const std::stop_token& stop) const override;
  [[nodiscard]] bool ClosesLate() const override { return !Answers({}); }

 private:
  GigeLink(const std::string& id, const GigeAnswer& announced, const GenicamOptions& options, Clock& clock,
           GObjectPointer<ArvCamera> camera);
  /// Whether something answers at its address that says to be this camera.
  [[nodiscard]] bool Answers(const std::stop_token& stop) const;

  double answer_s_;
  Clock& clock_;
};

}  // namespace rigcal
