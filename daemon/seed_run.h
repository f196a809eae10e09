#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "config/provenance.h"
#include "config/rig_file.h"
#include "core/base/result.h"
#include "core/scene/recording.h"
#include "core/seed/detect_chart.h"
#include "core/seed/seed_cameras.h"
#include "daemon/run_context.h"

namespace rigcal {

/// A recording of the chart, opened.
struct ChartRecording {
  std::filesystem::path folder;
  Recording recording;
  Board board;
  std::optional<RigFile> rig;
};

struct SeededRig {
  SeedScene scene;
  std::vector<ChartDetection> detections;  ///< one per view of the scene
  SeedResult seed;
};

/// Cameras from pictures of the chart: detect -> seed (DESIGN.md section 2). With a rig the views at its stops have the
/// poses that it gives them; all others, and without a rig all, have a pose of their own. Errors: kBadInput when the
/// recording shows no chart, and those of StopPositions, LoadRecordedPicture, DetectChart and SeedCameras.
Result<SeededRig> SeedRig(const ChartRecording& chart, RunContext& context);

/// Writes calibration.json and report.json into `folder`, each whole or not at all. Errors: kIo, kDiskFull.
Result<void> WriteSeedOutput(const SeededRig& rig, const Provenance& provenance, const std::filesystem::path& folder);

}  // namespace rigcal
