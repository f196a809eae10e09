#include "drivers/linuxcnc/find_linuxcnc_devices.h"

#include "drivers/linuxcnc/rsh_session.h"

namespace rigcal {
namespace {

/// What it does, and what keeps it from being moved.
void Describe(const RshState& state, FoundDevice& device) {
  if (state.emergency_stop) {
    device.state = "emergency stop";
    device.problem = "a person has to reset the emergency stop (F1, or 'set estop off' of linuxcncrsh)";
  } else if (!state.power) {
    device.state = "power off";  // as before every capture, which switches it on
  } else if (state.program == "PAUSED") {
    device.state = "paused";
    device.problem = "somebody paused it";
  } else {
    device.state = state.program == "RUNNING" ? "moving" : "idle";
  }
}

}  // namespace

Result<std::optional<FoundDevice>> FindLinuxcncDeviceAt(const std::string& address, Clock& clock,
                                                        const std::stop_token& stop) {
  const std::optional<SocketAddress> parsed = ParseSocketAddress(address, 1);
  if (!parsed) return Fail(ErrorCode::kBadInput, "linuxcnc: {}: the address is not HOST:PORT", address);
  FoundDevice device{.driver = "linuxcnc", .kind = DeviceKind::kPositioner, .address = address, .model = "LinuxCNC"};
  Result<RshSession> session = RshSession::Open(*parsed, RshRole::kLook, clock, stop);
  if (!session && session.error().code == ErrorCode::kUnsupported) {
    device.problem = session.error().message;
    return device;
  }
  if (!session && (session.error().code == ErrorCode::kDevice || session.error().code == ErrorCode::kTimeout)) {
    return std::nullopt;
  }
  if (!session) return Fail(session.error());
  device.firmware = "linuxcncrsh " + session->Server().substr(session->Server().rfind(' ') + 1);
  const Result<RshState> state = session->State(stop);
  if (state) {
    Describe(*state, device);
  } else if (state.error().code == ErrorCode::kCancelled) {
    return Fail(state.error());
  } else {
    device.problem = state.error().message;
  }
  return device;
}

Result<std::vector<FoundDevice>> FindLinuxcncDevices(Clock& clock, const std::stop_token& stop) {
  Result<std::optional<FoundDevice>> device = FindLinuxcncDeviceAt(kUsualRshAddress, clock, stop);
  if (!device) return Fail(device.error());
  if (!*device) return std::vector<FoundDevice>{};
  return std::vector<FoundDevice>{std::move(**device)};
}

}  // namespace rigcal
