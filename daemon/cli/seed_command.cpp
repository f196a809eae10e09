#include <fmt/format.h>

#include <memory>

#include "config/atomic_file.h"
#include "config/board_file.h"
#include "config/recording_file.h"
#include "config/run_report.h"
#include "config/seed_report.h"
#include "daemon/cli/number_options.h"
#include "daemon/cli/progress_line.h"
#include "daemon/cli/run_request.h"
#include "daemon/run_output.h"
#include "daemon/seed_run.h"

namespace rigcal {
namespace {

struct SeedRequest {
  std::filesystem::path recording, chart, rig, out;
  int num_threads = 0;  ///< 0: one for each processor
  bool json = false;
};

struct OpenedChart {
  ChartRecording chart;
  Provenance provenance;
};

/// The file as `parse` reads it; what was parsed is what the provenance names.
template <typename Content>
Result<Content> ReadInput(const std::filesystem::path& path,
                          Result<Content> (*parse)(std::string_view, const std::string&), Provenance& provenance) {
  const Result<std::string> text = ReadFile(path);
  if (!text) return Fail(text.error());
  provenance.inputs.push_back({path.filename().string(), Sha256Hex(*text)});
  return parse(*text, path.string());
}

Result<OpenedChart> Open(const SeedRequest& request) {
  OpenedChart opened{.chart = {.folder = request.recording},
                     .provenance = {.program_version = std::string(ProgramVersion()), .method = "seed"}};
  const Result<Board> board = ReadInput(request.chart, ParseBoard, opened.provenance);
  if (!board) return Fail(board.error());
  opened.chart.board = *board;
  if (!request.rig.empty()) {
    Result<RigFile> rig = ReadInput(request.rig, ParseRig, opened.provenance);
    if (!rig) return Fail(rig.error());
    opened.chart.rig = std::move(*rig);
  }
  const std::filesystem::path file = request.recording / kRecordingFile;
  Result<Recording> recording = ReadInput(file, ParseRecording, opened.provenance);
  if (!recording) return Fail(recording.error());
  if (!recording->closed) return Fail(ErrorCode::kBadInput, "{}: the recording is not closed", file.string());
  for (const RecordedView& view : recording->views) {
    if (view.subject != Subject::kObject) opened.provenance.inputs.push_back({view.file, view.sha256});
  }
  opened.chart.recording = std::move(*recording);
  return opened;
}

int Seed(const SeedRequest& request, const CommandSession& session) {
  if (auto ready = PrepareResultFolder(request.out, ""); !ready) return FailWith("seed", ready.error());
  ProgressLine line(session.on_terminal, MonotonicSeconds);
  RunContext context(session.stop, NumThreads(request.num_threads), MonotonicSeconds,
                     [&line](const RunProgress& progress) { line.Show(progress); });
  const Result<OpenedChart> opened = Open(request);
  if (!opened) return line.Clear(), FailWith("seed", opened.error());
  const Result<SeededRig> rig = SeedRig(opened->chart, context);
  if (!rig) return line.Clear(), FailWith("seed", rig.error());
  auto written = WriteSeedOutput(*rig, opened->provenance, request.out);
  if (written) written = WriteTimingJson(context.Timing(), request.out / "timing.json");
  line.Clear();
  if (!written) return FailWith("seed", written.error());
  fmt::print("{}", request.json ? SeedReportText(rig->scene, rig->detections, rig->seed)
                                : SeedSummaryText(rig->scene, rig->seed));
  return kExitAccepted;
}

}  // namespace

void AddSeedCommand(CLI::App& app, CommandSession& session) {
  CLI::App* command = app.add_subcommand("seed", "Calibrate cameras from a recording of the chart");
  auto request = std::make_shared<SeedRequest>();
  command->add_option("--recording", request->recording, "Folder with recording.json")->required();
  command->add_option("--chart", request->chart, "board.toml, as `chart print` writes it")->required();
  command->add_option("--rig", request->rig, "rig.toml: the stops are those of its positioner (docs/rig.md)");
  command->add_option("--out", request->out, "Folder for the results")->required();
  AddThreadsOption(*command, request->num_threads);
  command->add_flag("--json", request->json, "Prints report.json");
  command->callback([request, &session] { session.exit_status = Seed(*request, session); });
}

}  // namespace rigcal
