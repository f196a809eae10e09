#include "drivers/arm/arm_driver.h"

#include "core/base/ensure.h"
#include "drivers/arm/listed_arm.h"
#include "drivers/arm/programmed_arm.h"

namespace rigcal {
namespace {

class ArmDriver final : public Driver {
 public:
  explicit ArmDriver(DriverContext context) : context_(std::move(context)) {}

  Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                   const std::stop_token& /*stop*/) override {
    return Fail(ErrorCode::kUnsupported, "camera '{}': the driver arm has no cameras", settings.id);
  }

  Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& settings,
                                                           const std::stop_token& /*stop*/) override {
    const std::optional<SocketAddress> address = ParseSocketAddress(settings.address, kAnyPort);
    if (!address) return ListedArm::Open(settings, context_);
    Result<std::unique_ptr<ProgrammedArm>> arm = ProgrammedArm::Listen(*address, settings, *context_.clock);
    if (!arm) return Fail(arm.error());
    if (context_.tell) context_.tell(fmt::format("arm: waits for its program on {}", ToText((*arm)->Address())));
    return std::move(*arm);
  }

 private:
  DriverContext context_;
};

}  // namespace

Result<std::unique_ptr<Driver>> MakeArmDriver(const RigHardware& /*rig*/, const DriverContext& context,
                                              const std::stop_token& /*stop*/) {
  Ensure(context.clock != nullptr, "an arm needs a clock");
  return std::make_unique<ArmDriver>(context);
}

}  // namespace rigcal
