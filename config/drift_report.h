#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/drift/drift_trend.h"
#include "core/drift/judge_drift.h"

namespace rigcal {

/// What drift.json says (docs/schema/drift.schema.json): the finding, and what a later trend needs of it.
struct DriftReport {
  DriftFinding finding;
  std::string recording_id;
  std::optional<std::string> recorded_at;  ///< when its last picture was taken, ISO 8601, UTC; nothing: unknown
  std::string calibration_sha256;          ///< of the calibration in force
  std::vector<CameraTrend> trend;          ///< with this night; empty: too few nights with a known time
  std::vector<std::string> notes;
};

/// The text of drift.json. A number that is not finite becomes null.
std::string DriftText(const DriftReport& report);

/// What a trend needs of an earlier drift.json.
struct EarlierNight {
  std::string recording_id, calibration_sha256;
  std::optional<DriftNight> night;  ///< nothing: its time is unknown
};

/// `file` begins messages. Errors: kBadInput (not a drift.json), kUnsupported (a newer version).
Result<EarlierNight> ParseEarlierNight(std::string_view text, const std::string& file);

/// This night and the earlier ones under the same calibration, for TrendOf; a recording that is there twice counts
/// once. Empty when this night's time is unknown.
std::vector<DriftNight> NightsWith(const DriftReport& tonight, const std::vector<EarlierNight>& earlier);

}  // namespace rigcal
