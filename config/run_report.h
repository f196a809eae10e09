#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"
#include "core/validate/validate.h"

namespace rigcal {

/// One round of stereo, matching and adjustment (paper: Fig. 10, Table 1).
struct RoundReport {
  int level = 0;
  int num_patches = 0;
  int num_tracks = 0;
  int num_observations = 0;
  double reprojection_mean_px = 0;
  double reprojection_std_px = 0;
  std::vector<double> expected_error_px;  ///< per view: Er with which the round began
  double moved_px = 0;                    ///< mean motion at the object by the round, after the best similarity
};

/// How much of a view is object, and how that was told.
struct MaskReport {
  std::string view;
  std::string kind;  ///< "file", "dark", "static" or "none"
  double object_share = 1;
};

/// One camera of the result with the sigma of each intrinsic (0: held fixed).
struct CameraReport {
  Camera camera;
  IntrinsicVector sigma = IntrinsicVector::Zero();
};

/// What report.json says: everything a person needs to believe or disbelieve a result (docs/schema/report.schema.json).
struct RunReport {
  ValidationReport validation;
  std::string method;            ///< "rigcal" or "paper"
  double expected_error_px = 0;  ///< Er at the start
  bool expected_error_estimated = false;
  int level = 0;  ///< L of the first round
  std::vector<RoundReport> rounds;
  std::vector<int> views_per_track;  ///< [k]: tracks of the last round seen in k views (paper: Fig. 7)
  std::vector<CameraReport> cameras;
  std::vector<MaskReport> masks;
  std::optional<RigFit> rig;                ///< when the poses were those of a rig
  std::vector<std::string> contradictions;  ///< where the pictures and the rig disagree, and what moved
  std::vector<std::string> notes;
};

/// Seconds of one stage of one round; round -1: once per run (paper: Table 2).
struct StageTime {
  std::string stage;
  int round = -1;
  double wall_s = 0;
};

struct RunTiming {
  std::vector<StageTime> stages;
  double total_wall_s = 0;
};

/// As in report.json: accepted, rejected, inconclusive.
const char* NameOf(Verdict verdict);

/// "epipolar (left_03.png): 1.3 px against a limit of 1 px".
std::string ReasonText(const Reason& reason);

/// The texts of report.json and timing.json. A number that is not finite becomes null.
std::string ReportText(const RunReport& report);
std::string TimingText(const RunTiming& timing);

/// Write report.json and timing.json, whole or not at all. Errors: kIo, kDiskFull.
Result<void> WriteReportJson(const RunReport& report, const std::filesystem::path& path);
Result<void> WriteTimingJson(const RunTiming& timing, const std::filesystem::path& path);

}  // namespace rigcal
