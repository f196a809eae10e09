#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "drivers/sim/sim_rig.h"

namespace rigcal {

/// A camera of the simulated studio. It sees the table where it stands when it is fired.
class SimCamera final : public CameraDevice {
 public:
  /// Holds camera number `camera` of the rig, which nobody else does. Errors: kDevice (gone, or held by somebody),
  /// kNotFound (no such camera), kUnsupported (pixel format, region).
  static Result<std::unique_ptr<CameraDevice>> Open(std::shared_ptr<SimRig> rig, int camera,
                                                    const CameraSettings& settings);
  ~SimCamera() override;

  [[nodiscard]] const RecordedCamera& Identity() const override { return identity_; }
  Result<void> MakeReady(const std::stop_token& stop) override;
  Result<void> Fire() override;
  Result<CapturedPicture> Collect(double timeout_s, const std::stop_token& stop) override;
  Result<void> Restore(double timeout_s, const std::stop_token& stop) override;

 private:
  struct Shot {
    double angle_rad = 0;
    int attempt = 0;
  };
  SimCamera(std::shared_ptr<SimRig> rig, int camera, const CameraSettings& settings, int bits);
  /// Notices that the camera is gone. Errors: kDevice until Restore has brought it back.
  Result<void> CheckConnected();
  [[nodiscard]] tl::unexpected<Error> Stopped(const char* what) const;

  std::shared_ptr<SimRig> rig_;
  int camera_, bits_;
  RecordedCamera identity_;
  std::optional<double> exposure_us_, gain_db_;
  bool connected_ = true;
  std::optional<Shot> fired_;
  std::map<double, int> num_shots_by_angle_rad_;
  std::uint64_t number_ = 0;
  cv::Mat last_picture_;
};

}  // namespace rigcal
