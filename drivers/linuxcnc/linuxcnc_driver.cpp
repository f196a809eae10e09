#include "drivers/linuxcnc/linuxcnc_driver.h"

#include "core/base/ensure.h"
#include "drivers/linuxcnc/linuxcnc_positioner.h"

namespace rigcal {
namespace {

class LinuxcncDriver final : public Driver {
 public:
  explicit LinuxcncDriver(Clock& clock) : clock_(clock) {}

  Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                   const std::stop_token& /*stop*/) override {
    return Fail(ErrorCode::kUnsupported, "camera '{}': the driver linuxcnc moves axes, it has no cameras", settings.id);
  }

  Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& settings,
                                                           const std::stop_token& stop) override {
    return LinuxcncPositioner::Open(settings, clock_, stop);
  }

 private:
  Clock& clock_;
};

}  // namespace

Result<std::unique_ptr<Driver>> MakeLinuxcncDriver(const RigHardware& /*rig*/, const DriverContext& context,
                                                   const std::stop_token& /*stop*/) {
  Ensure(context.clock != nullptr, "a driver that waits needs a clock");
  return std::unique_ptr<Driver>(new LinuxcncDriver(*context.clock));
}

}  // namespace rigcal
