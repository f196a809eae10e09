#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "config/board_file.h"
#include "config/read_file.h"
#include "config/rig_file.h"
#include "config/rig_keys.h"
#include "config/rig_summary.h"
#include "daemon/cli/run_request.h"

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

int RunRigCheck(const std::filesystem::path& file) {
  const Result<RigFile> rig = CheckRigFile(file);
  if (!rig) return FailWith("rig check", rig.error());
  fmt::print("{}", RigSummaryText(*rig));
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
