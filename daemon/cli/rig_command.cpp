#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "config/board_file.h"
#include "config/read_file.h"
#include "config/rig_file.h"
#include "config/rig_keys.h"
#include "config/rig_summary.h"
#include "core/base/joined.h"
#include "daemon/cli/command.h"
#include "drivers/registry.h"

namespace rigcal {
namespace {

/// The rig file and the board that it names, read as a capture would read them.
Result<RigFile> CheckRigFile(const std::filesystem::path& file) {
  Result<RigFile> rig = LoadRig(file);
  if (!rig || rig->board.empty()) return rig;
  const Result<std::string> text = ReadFile(rig->board);
  if (!text) return Fail(text.error());
  if (const Result<Board> board = ParseBoard(*text, rig->board.string()); !board) return Fail(board.error());
  return rig;
}

/// A rig may be described before the program can move all of it; seeding and refinement need no driver.
std::vector<std::string> MissingDrivers(const RigFile& rig) {
  const std::vector<std::string> known = DriverNames();
  std::set<std::string> missing;
  const auto look = [&](const std::string& driver) {
    if (!driver.empty() && std::ranges::find(known, driver) == known.end()) missing.insert(driver);
  };
  look(rig.positioner.driver);
  for (const CameraSettings& camera : rig.cameras) look(camera.driver);
  return {missing.begin(), missing.end()};
}

int RunRigCheck(const std::filesystem::path& file) {
  const Result<RigFile> rig = CheckRigFile(file);
  if (!rig) return FailWith("rig check", rig.error());
  fmt::print("{}", RigSummaryText(*rig));
  for (const std::string& driver : MissingDrivers(*rig)) {
    fmt::print("note: `rigcal capture` cannot use this rig: this program has no driver '{}', it has {}\n", driver,
               Joined(DriverNames(), ", "));
  }
  return kExitAccepted;
}

}  // namespace

void AddRigCommand(CLI::App& app, CommandSession& session) {
  CLI::App* rig = app.add_subcommand("rig", "Rig files: the studio's devices and how exactly they repeat");
  rig->require_subcommand(1);
  CLI::App* check = rig->add_subcommand("check", "Whether a rig file can be used, and what it says");
  const auto file = std::make_shared<std::filesystem::path>();
  check->add_option("FILE", *file, "rig.toml (docs/rig.md)")->required();
  check->callback([file, &session] { session.exit_status = RunRigCheck(*file); });
  CLI::App* keys = rig->add_subcommand("keys", "Prints every key of a rig file, as markdown");
  keys->callback([] { fmt::print("{}", RigKeysMarkdown()); });
}

}  // namespace rigcal
