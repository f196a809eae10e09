#include "drivers/genicam/genicam_driver.h"

#include <algorithm>
#include <iterator>

#include "core/base/ensure.h"
#include "drivers/genicam/genicam_camera.h"
#include "drivers/usb/find_usb_cameras.h"

namespace rigcal {
namespace {

constexpr const char* kName = "genicam";
constexpr double kAnswer_s = 1;  ///< for what a camera that has just answered is asked further

class GenicamDriver final : public Driver {
 public:
  GenicamDriver(const GenicamOptions& options, const DriverContext& context)
      : options_(options), clock_(*context.clock), tell_(context.tell) {}

  Result<std::unique_ptr<CameraDevice>> OpenCamera(const CameraSettings& settings,
                                                   const std::stop_token& stop) override {
    return GenicamCamera::Open(settings, options_, tell_, clock_, stop);
  }

  Result<std::unique_ptr<PositionerDevice>> OpenPositioner(const PositionerSettings& /*settings*/,
                                                           const std::stop_token& /*stop*/) override {
    return Fail(ErrorCode::kUnsupported, "positioner: the driver genicam has cameras, it moves nothing");
  }

 private:
  GenicamOptions options_;
  Clock& clock_;
  std::function<void(const std::string&)> tell_;
};

/// Asks a camera that has answered who controls it.
Result<FoundDevice> Describe(const GigeAnswer& answer, Clock& clock, const std::stop_token& stop) {
  FoundDevice found{.driver = kName,
                    .kind = DeviceKind::kCamera,
                    .address = answer.address,
                    .serial = answer.serial,
                    .model = fmt::format("{} {}", answer.vendor, answer.model),
                    .firmware = answer.firmware};
  const Result<std::optional<GigeHolder>> holder = HolderOfGigeCamera(answer.address, kAnswer_s, clock, stop);
  if (!holder && holder.error().code == ErrorCode::kCancelled) return Fail(holder.error());
  if (!holder) {
    found.problem = fmt::format(
        "it answers to everybody, but not at its address {}: that is none of this machine's networks", answer.address);
  } else if (!*holder) {
    found.state = "free";
  } else {
    found.state =
        fmt::format("held by {}{}", (*holder)->address.empty() ? "a program that it does not name" : (*holder)->address,
                    (*holder)->exclusive ? ", exclusively" : "");
  }
  return found;
}

}  // namespace

std::unique_ptr<Driver> MakeGenicamDriver(const GenicamOptions& options, const DriverContext& context) {
  Ensure(context.clock != nullptr, "a driver that waits needs a clock");
  return std::make_unique<GenicamDriver>(options, context);
}

Result<std::unique_ptr<Driver>> MakeGenicamDriver(const RigHardware& /*rig*/, const DriverContext& context,
                                                  const std::stop_token& /*stop*/) {
  return MakeGenicamDriver(GenicamOptions{}, context);
}

Result<std::vector<FoundDevice>> FindGenicamDevices(GigeReach reach, Clock& clock, const std::stop_token& stop) {
  const Result<std::vector<GigeAnswer>> answers = FindGigeCameras(reach, std::nullopt, clock, stop);
  if (!answers) return Fail(answers.error());
  std::vector<FoundDevice> devices;
  for (const GigeAnswer& answer : *answers) {
    Result<FoundDevice> described = Describe(answer, clock, stop);
    if (!described) return Fail(described.error());
    devices.push_back(std::move(*described));
  }
  return devices;
}

Result<std::vector<FoundDevice>> FindGenicamDevices(Clock& clock, const std::stop_token& stop) {
  Result<std::vector<FoundDevice>> devices = FindGenicamDevices(GigeReach::kAllInterfaces, clock, stop);
  Result<std::vector<FoundDevice>> at_usb = FindUsbCameras(clock, stop);
  if (!devices || !at_usb) return devices ? at_usb : devices;
  std::ranges::move(*at_usb, std::back_inserter(*devices));
  return devices;
}

Result<std::optional<FoundDevice>> FindGenicamDeviceAt(const std::string& address, Clock& clock,
                                                       const std::stop_token& stop) {
  const Result<std::optional<GigeAnswer>> answer = AskGigeCamera(address, kAnswer_s, clock, stop);
  if (!answer) return Fail(answer.error());
  if (!*answer) return std::nullopt;
  Result<FoundDevice> described = Describe(**answer, clock, stop);
  if (!described) return Fail(described.error());
  return std::move(*described);
}

}  // namespace rigcal
