#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "config/rig_file.h"
#include "core/base/joined.h"
#include "daemon/cli/command.h"
#include "drivers/registry.h"

namespace rigcal {
namespace {

struct DevicesArguments {
  std::filesystem::path rig;
  bool json = false;
};

const char* NameOf(DeviceKind kind) {
  return kind == DeviceKind::kCamera ? "camera" : "positioner";
}

std::array<std::string, 7> RowOf(const FoundDevice& device) {
  return {NameOf(device.kind), device.driver,   device.address, device.serial,
          device.model,        device.firmware, device.state};
}

/// Columns as wide as their widest cell; under each device what is wrong with it.
void PrintTable(const std::vector<FoundDevice>& devices) {
  std::vector<std::array<std::string, 7>> rows = {
      {"kind", "driver", "address", "serial", "model", "firmware", "state"}};
  std::ranges::transform(devices, std::back_inserter(rows), RowOf);
  std::array<std::size_t, 7> widths{};
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      widths[c] = std::max(widths[c], std::max<std::size_t>(1, row[c].size()));
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::string line;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      line += fmt::format("{:<{}}  ", rows[r][c].empty() ? "-" : rows[r][c], widths[c]);
    }
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
    if (r > 0 && !devices[r - 1].problem.empty()) fmt::print("    {}\n", devices[r - 1].problem);
  }
}

void PrintJson(const DeviceSearch& search, const std::vector<std::string>& missing) {
  nlohmann::json devices = nlohmann::json::array();
  for (const FoundDevice& device : search.devices) {
    devices.push_back({{"kind", NameOf(device.kind)},
                       {"driver", device.driver},
                       {"address", device.address},
                       {"serial", device.serial},
                       {"model", device.model},
                       {"firmware", device.firmware},
                       {"state", device.state},
                       {"problem", device.problem}});
  }
  const nlohmann::json report = {
      {"devices", devices}, {"looked_at", search.looked_at}, {"failures", search.failures}, {"missing", missing}};
  // What a device says of itself need not be UTF-8.
  fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

int ListDevices(const DevicesArguments& arguments, const CommandSession& session) {
  RigHardware hardware;
  if (!arguments.rig.empty()) {
    const Result<RigFile> rig = LoadRig(arguments.rig);
    if (!rig) return FailWith("devices", rig.error());
    hardware = {.cameras = rig->cameras, .positioner = rig->positioner};
  }
  SystemClock clock;
  const Result<DeviceSearch> search = FindDevices(hardware, clock, session.stop);
  if (!search) return FailWith("devices", search.error());
  const std::vector<std::string> missing = MissingDevices(hardware, search->devices);
  if (arguments.json) {
    PrintJson(*search, missing);
  } else {
    if (search->devices.empty()) fmt::print("no device is found; looked at: {}\n", Joined(search->looked_at, ", "));
    if (!search->devices.empty()) PrintTable(search->devices);
    for (const std::string& failure : search->failures) fmt::print(stderr, "rigcal devices: {}\n", failure);
    for (const std::string& sentence : missing) fmt::print("missing: {}\n", sentence);
  }
  return missing.empty() ? kExitAccepted : kExitNotAccepted;
}

}  // namespace

void AddDevicesCommand(CLI::App& app, CommandSession& session) {
  CLI::App* devices = app.add_subcommand("devices", "Every camera and positioner found, and what is wrong with it");
  const auto arguments = std::make_shared<DevicesArguments>();
  devices->add_option("--rig", arguments->rig, "rig.toml: also says which of its devices are missing (status 3)");
  devices->add_flag("--json", arguments->json, "as JSON");
  devices->callback([arguments, &session] { session.exit_status = ListDevices(*arguments, session); });
}

}  // namespace rigcal
