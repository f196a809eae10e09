#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <set>

#include "config/recording_check.h"
#include "config/recording_file.h"
#include "config/recording_import.h"
#include "config/recording_prune.h"
#include "config/rig_file.h"
#include "config/store/sqlite_store.h"
#include "daemon/cli/command.h"
#include "daemon/cli/store_options.h"
#include "daemon/run_context.h"

namespace rigcal {
namespace {

struct ImportArguments {
  PictureFolder pictures;
  std::string subject;
  std::filesystem::path out;
};

std::string Summary(const Recording& recording) {
  return fmt::format("{} cameras, {} stops, {} views", recording.cameras.size(), recording.stops.size(),
                     recording.views.size());
}

int RunImport(ImportArguments& arguments, const CommandSession& session) {
  for (const Subject subject : {Subject::kChart, Subject::kObject, Subject::kBoth})
    if (arguments.subject == NameOf(subject)) arguments.pictures.subject = subject;
  Execution execution{.stop = session.stop};
  if (session.on_terminal)
    execution.report_progress = [](double share) { fmt::print(stderr, "\rimport {:3.0f} %", 100 * share); };
  const Result<Recording> recording = ImportRecording(arguments.pictures, arguments.out, execution);
  if (session.on_terminal) fmt::print(stderr, "\n");
  if (!recording) return FailWith("recording import", recording.error());
  fmt::print("{}: {}\n", arguments.out.string(), Summary(*recording));
  return kExitAccepted;
}

int RunCheck(const std::filesystem::path& folder, const CommandSession& session) {
  const auto findings = CheckRecording(folder, {.stop = session.stop, .num_threads = NumThreads(0)});
  if (!findings) return FailWith("recording check", findings.error());
  for (const std::string& fault : findings->faults) fmt::print("fault: {}\n", fault);
  for (const std::string& remark : findings->remarks) fmt::print("note: {}\n", remark);
  fmt::print("{}: {}, {}, {} faults\n", folder.string(), findings->recording.closed ? "closed" : "not closed",
             Summary(findings->recording), findings->faults.size());
  return findings->faults.empty() ? kExitAccepted : kExitBadInput;
}

struct PruneArguments {
  std::filesystem::path rig, recordings;
  std::optional<std::filesystem::path> state;  ///< nothing: the usual one, where it has a store
  std::vector<std::string> keep;
  bool dry_run = false;
};

/// What the revisions of the store were made from. Without a store in the usual place there are none.
Result<std::set<std::string>> OfRevisions(const PruneArguments& arguments) {
  const std::filesystem::path file = arguments.state.value_or(StoreChoice().state) / kStoreFile;
  const auto store = OpenSqliteStore(file);
  if (store) return RecordingsOfRevisions(**store);
  if (arguments.state || store.error().code != ErrorCode::kNotFound) return Fail(store.error());
  fmt::print("note: {}: there is no calibration store, so only --keep says what is needed\n", file.string());
  return std::set<std::string>();
}

int RunPrune(const PruneArguments& arguments, const CommandSession& session) {
  const Result<RigFile> rig = LoadRig(arguments.rig);
  if (!rig) return FailWith("recording prune", rig.error());
  const auto of_revisions = OfRevisions(arguments);
  if (!of_revisions) return FailWith("recording prune", of_revisions.error());
  const PruneOptions options{.rule = rig->keep,
                             .needed = {arguments.keep.begin(), arguments.keep.end()},
                             .of_revisions = *of_revisions,
                             .dry_run = arguments.dry_run};
  const auto report = PruneRecordings(arguments.recordings, options, RealSurroundings(), session.stop);
  if (!report) return FailWith("recording prune", report.error());
  for (const PrunedRecording& gone : report->gone)
    fmt::print("{}: {}: {}\n", arguments.dry_run ? "would go" : "gone", gone.folder.string(), gone.reason);
  for (const std::string& remark : report->remarks) fmt::print("note: {}\n", remark);
  fmt::print("{}: {} {}, {} left\n", arguments.recordings.string(), report->gone.size(),
             arguments.dry_run ? "would go" : "gone", report->num_left);
  return report->failure ? FailWith("recording prune", *report->failure) : kExitAccepted;
}

void AddPruneCommand(CLI::App& recording, CommandSession& session) {
  CLI::App* command = recording.add_subcommand("prune", "Removes old recordings by the rule of a rig file");
  const auto arguments = std::make_shared<PruneArguments>();
  command->add_option("--rig", arguments->rig, "rig.toml; its [keep] is the rule")->required();
  command->add_option("--recordings", arguments->recordings, "Folder in which the recordings lie")->required();
  command->add_option("--state", arguments->state,
                      "Folder with the calibration store, whose revisions' recordings never go; else /var/lib/rigcal");
  command->add_option("--keep", arguments->keep, "Ids of other recordings that never go")->delimiter(',');
  command->add_flag("--dry-run", arguments->dry_run, "Says what would go, and touches nothing");
  command->callback([arguments, &session] { session.exit_status = RunPrune(*arguments, session); });
}

void AddImportCommand(CLI::App& recording, CommandSession& session) {
  CLI::App* command = recording.add_subcommand("import", "Makes a recording of pictures taken by something else");
  auto arguments = std::make_shared<ImportArguments>();
  PictureFolder& pictures = arguments->pictures;
  command->add_option("--images", pictures.folder, "Folder of pictures; they are copied")->required();
  command->add_option("--camera-from-name", pictures.camera_from_name,
                      "Regular expression on the image's name; its first group is the physical camera");
  command->add_option("--stop-from-name", pictures.stop_from_name,
                      "The same for the stop; without it each picture has a pose of its own");
  command->add_option("--angles-deg", pictures.angles_deg,
                      "The table's angle at the stops: START:STEP, or a file of lines 'STOP ANGLE'");
  command->add_option("--what", arguments->subject, "What is seen")
      ->required()
      ->check(CLI::IsMember({"chart", "object", "both"}));
  command->add_flag("--linear", pictures.linear, "Pixel values are proportional to the light, not gamma-encoded");
  command->add_option("--out", arguments->out, "Folder of the recording; must not be there, or be empty")->required();
  command->callback([arguments, &session] { session.exit_status = RunImport(*arguments, session); });
}

}  // namespace

void AddRecordingCommand(CLI::App& app, CommandSession& session) {
  CLI::App* recording = app.add_subcommand("recording", "Recordings: pictures with their cameras and stops");
  recording->require_subcommand(1);
  AddImportCommand(*recording, session);
  AddPruneCommand(*recording, session);
  CLI::App* check = recording->add_subcommand("check", "Whether a recording is whole and unchanged");
  auto folder = std::make_shared<std::filesystem::path>();
  check->add_option("DIR", *folder, "Folder of the recording")->required();
  check->callback([folder, &session] { session.exit_status = RunCheck(*folder, session); });
}

}  // namespace rigcal
