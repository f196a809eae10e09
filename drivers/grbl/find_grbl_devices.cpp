#include "drivers/grbl/find_grbl_devices.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "drivers/grbl/serial_line.h"

namespace rigcal {
namespace {

constexpr double kAnswer_s = 3;    ///< a board that was reset by the opening is in its boot loader for 2 s
constexpr double kAskAgain_s = 1;  ///< a question that fell into the boot loader is asked again
constexpr std::string_view kByName = "/dev/serial/by-id", kDevices = "/dev";
constexpr std::string_view kVersion = "[VER:";

tl::unexpected<Error> Stopped(const std::string& line) {
  return Fail(ErrorCode::kCancelled, "grbl: {}: looking for a board was stopped on request", line);
}

/// The next line for which `take` has a value. Nothing when none came in time.
template <typename Take>
auto Await(SerialLine& line, const std::string& question, Take take, Clock& clock, const std::stop_token& stop)
    -> Result<decltype(take(GrblLine()))> {
  const double begin_s = clock.NowS();
  double next_s = begin_s;
  while (clock.NowS() - begin_s <= kAnswer_s) {
    if (stop.stop_requested()) return Stopped(line.Path());
    if (clock.NowS() >= next_s) {
      next_s = clock.NowS() + kAskAgain_s;
      if (Result<void> sent = line.Write(question); !sent) return Fail(sent.error());
    }
    const Result<std::optional<std::string>> text = line.ReadLine();
    if (!text) return Fail(text.error());
    if (!*text) continue;
    if (auto taken = take(ParseGrblLine(**text))) return taken;
  }
  return decltype(take(GrblLine()))();
}

std::optional<GrblStatus> TakeStatus(const GrblLine& line) {
  if (line.kind != GrblLineKind::kStatus) return std::nullopt;
  return line.status;
}

/// "1.1h.20190825" of "[VER:1.1h.20190825:]"; a refusal ends the waiting with an empty one.
std::optional<std::string> TakeVersion(const GrblLine& line) {
  if (line.kind == GrblLineKind::kError) return "";
  if (!line.text.starts_with(kVersion)) return std::nullopt;
  const std::string_view version = std::string_view(line.text).substr(kVersion.size());
  return std::string(version.substr(0, version.find_first_of(":]")));
}

std::string ProblemOf(GrblState state) {
  if (state == GrblState::kAlarm) return "it is locked by an alarm until it is homed, as a capture does first";
  if (state == GrblState::kDoor) return "the safety door is open";
  if (state == GrblState::kSleep) return "it sleeps until it is reset";
  return "";
}

}  // namespace

std::vector<std::string> SerialLinesPresent() {
  std::vector<std::string> lines;
  std::set<std::filesystem::path> named;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(kByName, ignored)) {
    lines.push_back(entry.path().string());
    named.insert(std::filesystem::weakly_canonical(entry.path(), ignored));
  }
  for (const auto& entry : std::filesystem::directory_iterator(kDevices, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool serial = name.starts_with("ttyUSB") || name.starts_with("ttyACM");
    if (serial && !named.contains(entry.path())) lines.push_back(entry.path().string());
  }
  std::ranges::sort(lines);
  return lines;
}

Result<std::optional<FoundDevice>> FindGrblDeviceAt(const std::string& path, Clock& clock,
                                                    const std::stop_token& stop) {
  FoundDevice device{.driver = "grbl", .kind = DeviceKind::kPositioner, .address = path};
  Result<SerialLine> line = SerialLine::Open(path);
  if (!line && line.error().message.ends_with(SerialLine::kHeld)) {
    device.state = "held by another program";
    device.problem = "it was not asked what it is";
    return device;
  }
  if (!line) return Fail(line.error());
  const auto status = Await(*line, "?", TakeStatus, clock, stop);
  if (!status) return Fail(status.error());
  if (!*status) return std::nullopt;
  device.model = "GRBL";
  device.state = NameOf((*status)->state);
  std::ranges::transform(device.state, device.state.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  device.problem = ProblemOf((*status)->state);
  if ((*status)->state != GrblState::kIdle && (*status)->state != GrblState::kAlarm) return device;  // it would refuse
  const auto version = Await(*line, "$I\n", TakeVersion, clock, stop);
  if (!version) return Fail(version.error());
  device.firmware = version->value_or("");
  return device;
}

Result<std::vector<FoundDevice>> FindGrblDevices(Clock& clock, const std::stop_token& stop) {
  std::vector<FoundDevice> devices;
  for (const std::string& line : SerialLinesPresent()) {
    Result<std::optional<FoundDevice>> device = FindGrblDeviceAt(line, clock, stop);
    if (!device && device.error().code == ErrorCode::kCancelled) return Fail(device.error());
    if (device && *device) devices.push_back(std::move(**device));
    if (device || device.error().code == ErrorCode::kNotFound) continue;  // unplugged meanwhile
    devices.push_back({.driver = "grbl",
                       .kind = DeviceKind::kPositioner,
                       .address = line,
                       .state = "not asked",
                       .problem = device.error().message});
  }
  return devices;
}

}  // namespace rigcal
