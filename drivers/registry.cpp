#include "drivers/registry.h"

#include <algorithm>
#include <array>
#include <map>

#include "core/base/joined.h"
#include "drivers/arm/arm_driver.h"
#include "drivers/genicam/genicam_driver.h"
#include "drivers/grbl/grbl_driver.h"
#include "drivers/linuxcnc/linuxcnc_driver.h"
#include "drivers/replay/replay_driver.h"
#include "drivers/sim/sim_driver.h"

namespace rigcal {
namespace {

struct DriverEntry {
  std::string_view name;
  bool real;  ///< hardware, as opposed to something that plays it
  Result<std::unique_ptr<Driver>> (*make)(const RigHardware& rig, const DriverContext& context,
                                          const std::stop_token& stop);
};

constexpr std::array kDrivers = {
    DriverEntry{"arm", true, MakeArmDriver},        DriverEntry{"genicam", true, MakeGenicamDriver},
    DriverEntry{"grbl", true, MakeGrblDriver},      DriverEntry{"linuxcnc", true, MakeLinuxcncDriver},
    DriverEntry{"replay", false, MakeReplayDriver}, DriverEntry{"sim", false, MakeSimDriver},
};

/// The drivers of one rig, each made when its first device is opened.
class RigDrivers {
 public:
  RigDrivers(const RigHardware& rig, const DriverContext& context, const std::stop_token& stop)
      : rig_(rig), context_(context), stop_(stop) {}

  /// `of` says in messages whose driver it is.
  Result<Driver*> Find(const std::string& name, const std::string& of, bool& real) {
    const auto entry = std::ranges::find(kDrivers, name, &DriverEntry::name);
    if (entry == kDrivers.end()) {
      return Fail(ErrorCode::kBadInput, "{}: there is no driver '{}', this program has {}", of, name,
                  Joined(DriverNames(), ", "));
    }
    real = real || entry->real;
    std::unique_ptr<Driver>& driver = drivers_[name];
    if (!driver) {
      Result<std::unique_ptr<Driver>> made = entry->make(rig_, context_, stop_);
      if (!made) return Fail(made.error());
      driver = std::move(*made);
    }
    return driver.get();
  }

 private:
  const RigHardware& rig_;
  const DriverContext& context_;
  const std::stop_token& stop_;
  std::map<std::string, std::unique_ptr<Driver>> drivers_;
};

}  // namespace

std::vector<std::string> DriverNames() {
  std::vector<std::string> names;
  for (const DriverEntry& entry : kDrivers) names.emplace_back(entry.name);
  return names;
}

Result<OpenedRig> OpenRig(const RigHardware& rig, const DriverContext& context, const std::stop_token& stop) {
  RigDrivers drivers(rig, context, stop);
  OpenedRig opened;
  for (const CameraSettings& settings : rig.cameras) {
    const Result<Driver*> driver = drivers.Find(settings.driver, fmt::format("camera '{}'", settings.id), opened.real);
    if (!driver) return Fail(driver.error());
    Result<std::unique_ptr<CameraDevice>> camera = (*driver)->OpenCamera(settings, stop);
    if (!camera) return Fail(camera.error());
    opened.cameras.push_back(std::move(*camera));
  }
  if (rig.positioner.driver.empty()) return opened;
  const Result<Driver*> driver = drivers.Find(rig.positioner.driver, "positioner", opened.real);
  if (!driver) return Fail(driver.error());
  Result<std::unique_ptr<PositionerDevice>> positioner = (*driver)->OpenPositioner(rig.positioner, stop);
  if (!positioner) return Fail(positioner.error());
  opened.positioner = std::move(*positioner);
  return opened;
}

}  // namespace rigcal
