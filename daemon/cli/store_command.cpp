#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "config/result_folder.h"
#include "config/run_report.h"
#include "config/store/sqlite_store.h"
#include "daemon/cli/command.h"
#include "daemon/cli/store_options.h"

namespace rigcal {
namespace {

struct StoreArguments {
  StoreChoice choice;
  std::filesystem::path result, recording, file;
};

int RunAdd(const StoreArguments& arguments, const CommandSession& /*session*/) {
  const auto store = OpenSqliteStore(arguments.choice.state / kStoreFile, {.create = true});
  if (!store) return FailWith("store add", store.error());
  const auto revision =
      RevisionFromResult(arguments.result, arguments.recording, arguments.choice.rig, NowText(), **store);
  if (!revision) return FailWith("store add", revision.error());
  const auto number = (*store)->Append(*revision);
  if (!number) return FailWith("store add", number.error());
  fmt::print("revision {} of rig '{}': {}\n", *number, revision->head.rig, NameOf(revision->head.verdict));
  return kExitAccepted;
}

int RunBackup(const StoreArguments& arguments, const CommandSession& /*session*/) {
  const auto store = OpenSqliteStore(arguments.choice.state / kStoreFile);
  if (!store) return FailWith("store backup", store.error());
  if (auto written = (*store)->Backup(arguments.file); !written) return FailWith("store backup", written.error());
  return kExitAccepted;
}

int RunCheck(const StoreArguments& arguments, const CommandSession& session) {
  const auto store = OpenSqliteStore(arguments.choice.state / kStoreFile);
  if (!store) return FailWith("store check", store.error());
  const auto findings = (*store)->Check(session.stop);
  if (!findings) return FailWith("store check", findings.error());
  for (const std::string& finding : *findings) fmt::print("{}\n", finding);
  if (findings->empty()) fmt::print("nothing is wrong\n");
  return findings->empty() ? kExitAccepted : kExitBadInput;
}

}  // namespace

void AddStoreCommand(CLI::App& app, CommandSession& session) {
  CLI::App* store = app.add_subcommand("store", "Look after the calibration store");
  store->require_subcommand(1);
  auto arguments = std::make_shared<StoreArguments>();
  const auto add_command = [&](const char* name, const char* what,
                               int (*run)(const StoreArguments&, const CommandSession&)) {
    CLI::App* command = store->add_subcommand(name, what);
    command->add_option("--state", arguments->choice.state, "Folder with the calibration store")->capture_default_str();
    command->callback([arguments, &session, run] { session.exit_status = run(*arguments, session); });
    return command;
  };
  CLI::App* add = add_command("add", "Keep the results of `refine` or `seed` as a revision", RunAdd);
  add->add_option("RESULT", arguments->result, "Folder with calibration.json and report.json")->required();
  add->add_option("--rig", arguments->choice.rig, "Name of the rig")->required();
  add->add_option("--recording", arguments->recording, "The recording it was made from, for its id");
  CLI::App* backup = add_command("backup", "Write the whole store to a new file", RunBackup);
  backup->add_option("FILE", arguments->file, "File to write; must not be there")->required();
  add_command("check", "Read every byte of the store and say what is wrong", RunCheck);
}

}  // namespace rigcal
