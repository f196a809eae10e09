#include "daemon/seed_request.h"

#include "config/board_file.h"
#include "config/recording_file.h"
#include "config/run_report.h"
#include "daemon/run_output.h"

namespace rigcal {
namespace {

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

}  // namespace

Result<SeededRig> SeedFiles(const SeedRequest& request, RunContext& context) {
  if (auto ready = PrepareResultFolder(request.out, ""); !ready) return Fail(ready.error());
  const Result<OpenedChart> opened = Open(request);
  if (!opened) return Fail(opened.error());
  Result<SeededRig> rig = SeedRig(opened->chart, context);
  if (!rig) return Fail(rig.error());
  auto written = WriteSeedOutput(*rig, opened->provenance, request.out);
  if (written) written = WriteTimingJson(context.Timing(), request.out / "timing.json");
  if (!written) return Fail(written.error());
  return rig;
}

}  // namespace rigcal
