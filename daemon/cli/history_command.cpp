#include <fmt/format.h>

#include <memory>

#include "daemon/cli/command.h"
#include "daemon/cli/store_options.h"
#include "daemon/store_diff.h"
#include "daemon/store_report.h"

namespace rigcal {
namespace {

struct HistoryArguments {
  StoreChoice choice;
  std::string revision, other;
  bool json = false, calibration = false, report = false;
};

int RunHistory(const HistoryArguments& arguments) {
  const auto opened = OpenRigStore(arguments.choice);
  if (!opened) return FailWith("history", opened.error());
  const auto history = opened->store->History(opened->rig);
  if (!history) return FailWith("history", history.error());
  fmt::print("{}", arguments.json ? HistoryJson(*history) : HistoryText(*history));
  return kExitAccepted;
}

int RunShow(const HistoryArguments& arguments) {
  const auto number = RevisionNumber(arguments.revision);
  if (!number) return FailWith("show", number.error());
  const auto opened = OpenRigStore(arguments.choice);
  if (!opened) return FailWith("show", opened.error());
  const auto revision = opened->store->Load(opened->rig, *number);
  if (!revision) return FailWith("show", revision.error());
  const auto history = opened->store->History(opened->rig);
  if (!history) return FailWith("show", history.error());
  if (arguments.calibration) {
    fmt::print("{}", revision->calibration_text);
  } else if (arguments.report) {
    fmt::print("{}", revision->report_text);
  } else {
    fmt::print("{}", arguments.json ? RevisionJson(revision->head, history->events)
                                    : RevisionText(revision->head, history->events));
  }
  return kExitAccepted;
}

int RunDiff(const HistoryArguments& arguments) {
  const auto before = RevisionNumber(arguments.revision), after = RevisionNumber(arguments.other);
  if (!before) return FailWith("diff", before.error());
  if (!after) return FailWith("diff", after.error());
  const auto opened = OpenRigStore(arguments.choice);
  if (!opened) return FailWith("diff", opened.error());
  const auto diff = DiffRevisions(*opened->store, opened->rig, *before, *after);
  if (!diff) return FailWith("diff", diff.error());
  fmt::print("{}", arguments.json ? DiffJson(*diff) : DiffText(*diff));
  return kExitAccepted;
}

}  // namespace

void AddHistoryCommands(CLI::App& app, CommandSession& session) {
  auto arguments = std::make_shared<HistoryArguments>();
  const auto add = [&](const char* name, const char* what, int (*run)(const HistoryArguments&)) {
    CLI::App* command = app.add_subcommand(name, what);
    AddStoreOptions(*command, arguments->choice);
    command->add_flag("--json", arguments->json, "Print JSON");
    command->callback([arguments, &session, run] { session.exit_status = run(*arguments); });
    return command;
  };
  add("history", "The revisions of a rig and when which was published", RunHistory);
  CLI::App* show = add("show", "What a revision is and what it was made from", RunShow);
  show->add_option("REV", arguments->revision, "Number of the revision")->required();
  show->add_flag("--calibration", arguments->calibration, "Print its calibration.json");
  show->add_flag("--report", arguments->report, "Print its report.json");
  CLI::App* diff = add("diff", "Which camera moved from one revision to another, by how much and which way", RunDiff);
  diff->add_option("A", arguments->revision, "Revision of before")->required();
  diff->add_option("B", arguments->other, "Revision of after")->required();
}

}  // namespace rigcal
