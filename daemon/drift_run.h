#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "config/drift_report.h"
#include "config/load_images.h"
#include "config/recording_pictures.h"
#include "config/run_report.h"
#include "core/base/result.h"
#include "core/drift/judge_drift.h"
#include "core/scene/rig_calibration.h"
#include "daemon/run_context.h"

namespace rigcal {

/// The night's recording, opened (LoadRecordedObject).
struct NightRecording {
  std::filesystem::path folder;
  RecordedObject recorded;
};

/// A calibration that was made with a rig, as it is in force.
struct CalibrationInForce {
  RigCalibration calibration;
  std::string name;  ///< in messages
  std::string sha256;
};

struct DriftOptions {
  DriftLimits limits;
  std::optional<double> expected_error_px;  ///< Er; estimated from the pictures when absent
  MaskSource masks = MaskSource::kAuto;
  std::uint64_t random_seed = 1;
};

struct DriftCheck {
  DriftReport report;    ///< without a trend
  RunReport refinement;  ///< of the refinement that it rests on
};

/// Does the calibration in force still hold? Places the night's views by it, refines with every mount let go of,
/// measures hold-out errors under it as it is and as refined, and judges (core/drift). Never changes the calibration.
/// Pictures that cannot carry a refinement make the finding inconclusive. Errors: those of PlaceRecording and
/// LoadImages, kCancelled.
Result<DriftCheck> CheckDrift(const NightRecording& night, const CalibrationInForce& in_force,
                              const DriftOptions& options, RunContext& context);

}  // namespace rigcal
