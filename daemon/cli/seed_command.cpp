#include <fmt/format.h>

#include <memory>

#include "config/seed_report.h"
#include "daemon/cli/command.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/progress_line.h"
#include "daemon/seed_request.h"

namespace rigcal {
namespace {

struct SeedArguments {
  SeedRequest request;
  int num_threads = 0;  ///< 0: one for each processor
  bool json = false;
};

int Seed(const SeedArguments& arguments, const CommandSession& session) {
  ProgressLine line(session.on_terminal, MonotonicSeconds);
  RunContext context(session.stop, NumThreads(arguments.num_threads), MonotonicSeconds,
                     [&line](const RunProgress& progress) { line.Show(progress); });
  const Result<SeededRig> rig = SeedFiles(arguments.request, context);
  line.Clear();
  if (!rig) return FailWith("seed", rig.error());
  fmt::print("{}", arguments.json ? SeedReportText(rig->scene, rig->detections, rig->seed)
                                  : SeedSummaryText(rig->scene, rig->seed));
  return kExitAccepted;
}

}  // namespace

void AddSeedCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command = app.add_subcommand("seed", "Calibrate cameras from a recording of the chart");
  auto arguments = std::make_shared<SeedArguments>();
  SeedRequest& request = arguments->request;
  command->add_option("--recording", request.recording, "Folder with recording.json")->required();
  command->add_option("--chart", request.chart, "board.toml, as `chart print` writes it")->required();
  command->add_option("--rig", request.rig, "rig.toml: the stops are those of its positioner (docs/rig.md)");
  command->add_option("--out", request.out, "Folder for the results")->required();
  AddThreadsOption(*command, arguments->num_threads);
  command->add_flag("--json", arguments->json, "Prints report.json");
  command->callback([arguments, &session] { session.exit_status = Seed(*arguments, session); });
}

}  // namespace rigcal
