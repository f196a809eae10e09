#include "daemon/seed_run.h"

#include <algorithm>
#include <optional>

#include "config/atomic_file.h"
#include "config/calibration_file.h"
#include "config/decode_image.h"
#include "config/recording_pictures.h"
#include "config/seed_report.h"

namespace rigcal {
namespace {

/// The recording's views that show the chart.
std::vector<int> ChartViews(const Recording& recording) {
  std::vector<int> views;
  for (int v = 0; v < static_cast<int>(recording.views.size()); ++v) {
    if (recording.views[v].subject != Subject::kObject) views.push_back(v);
  }
  return views;
}

Result<SeedScene> SceneOf(const ChartRecording& chart, const std::vector<int>& views) {
  SeedScene scene{.board = chart.board};
  if (chart.rig) {
    Result<std::vector<StopPosition>> stops = StopPositions(chart.recording, *chart.rig, chart.folder.string());
    if (!stops) return Fail(stops.error());
    scene.stops = std::move(*stops);
    scene.rig = chart.rig->model;
  }
  for (const RecordedCamera& camera : chart.recording.cameras) {
    scene.cameras.push_back({camera.id, camera.width_px, camera.height_px});
  }
  for (int v : views) {
    const RecordedView& view = chart.recording.views[v];
    scene.views.push_back({view.file, view.camera, chart.rig ? view.stop : std::nullopt});
  }
  return scene;
}

Result<ChartDetection> DetectIn(const ChartRecording& chart, int view) {
  const Result<cv::Mat> picture = LoadRecordedPicture(chart.folder, chart.recording, view);
  if (!picture) return Fail(picture.error());
  return DetectChart(GrayOf(*picture), chart.board, {.linear = chart.recording.linear});
}

/// Without a corner anywhere, what is wrong with the first picture that says so is the reason for all.
Result<void> CheckSeen(const ChartRecording& chart, const SeedScene& scene,
                       const std::vector<ChartDetection>& detections) {
  if (std::ranges::any_of(detections, [](const ChartDetection& d) { return !d.corners.empty(); })) return {};
  for (std::size_t v = 0; v < detections.size(); ++v) {
    std::string reasons;
    for (const ChartFinding& finding : detections[v].findings) {
      (reasons += reasons.empty() ? "" : "; ") += finding.message;
    }
    if (reasons.empty()) continue;
    return Fail(ErrorCode::kBadInput, "{}: none of {} pictures shows the chart; '{}': {}", chart.folder.string(),
                detections.size(), scene.views[v].name, reasons);
  }
  return Fail(ErrorCode::kBadInput, "{}: none of {} pictures shows the chart", chart.folder.string(),
              detections.size());
}

}  // namespace

Result<SeededRig> SeedRig(const ChartRecording& chart, RunContext& context) {
  const std::vector<int> views = ChartViews(chart.recording);
  if (views.empty()) {
    return Fail(ErrorCode::kBadInput, "{}: none of its {} pictures is one of the chart", chart.folder.string(),
                chart.recording.views.size());
  }
  Result<SeedScene> scene = SceneOf(chart, views);
  if (!scene) return Fail(scene.error());
  SeededRig rig{.scene = std::move(*scene)};
  Result<std::vector<ChartDetection>> detections = context.Time("detect", -1, [&](const Execution& execution) {
    return ParallelResults<ChartDetection>(execution, static_cast<int>(views.size()), "looking for the chart",
                                           [&](int i) { return DetectIn(chart, views[i]); });
  });
  if (!detections) return Fail(detections.error());
  if (auto seen = CheckSeen(chart, rig.scene, *detections); !seen) return Fail(seen.error());
  for (int v = 0; v < static_cast<int>(views.size()); ++v) rig.scene.sightings.push_back({v, (*detections)[v].corners});

  Result<SeedResult> seed = context.Time(
      "seed", -1, [&](const Execution& execution) { return SeedCameras(rig.scene, SeedOptions{}, execution); });
  if (!seed) return Fail(seed.error());
  rig.detections = std::move(*detections);
  rig.seed = std::move(*seed);
  if (rig.seed.calibration.rig) rig.seed.calibration.rig->axes = chart.rig->axes;
  return rig;
}

Result<void> WriteSeedOutput(const SeededRig& rig, const Provenance& provenance, const std::filesystem::path& folder) {
  if (auto written = WriteCalibration(folder / "calibration.json", rig.seed.calibration, provenance); !written) {
    return written;
  }
  return WriteFileAtomically(folder / "report.json", SeedReportText(rig.scene, rig.detections, rig.seed));
}

}  // namespace rigcal
