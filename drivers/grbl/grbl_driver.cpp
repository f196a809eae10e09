#include "drivers/grbl/grbl_driver.h"

#include "core/base/ensure.h"
#include "drivers/grbl/grbl_positioner.h"

namespace rigcal {
namespace {

class GrblDriver final : public Driver {
 public:
  explicit GrblDriver(Clock& clock) : clock_(clock) {}

  Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                   const std::stop_token& /*stop*/) override {
    return Fail(ErrorCode::kUnsupported, "camera '{}': the driver grbl moves axes, it has no cameras", settings.id);
  }

  Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& settings,
                                                           const std::stop_token& stop) override {
    return GrblPositioner::Open(settings, clock_, stop);
  }

 private:
  Clock& clock_;
};

}  // namespace

Result<std::unique_ptr<Driver>> MakeGrblDriver(const RigHardware& /*rig*/, const DriverContext& context,
                                               const std::stop_token& /*stop*/) {
  Ensure(context.clock != nullptr, "a driver that waits needs a clock");
  return std::unique_ptr<Driver>(new GrblDriver(*context.clock));
}

}  // namespace rigcal
