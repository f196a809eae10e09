#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/camera_records.h"
#include "config/provenance.h"
#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// The text of a calibration.json (docs/schema/calibration.schema.json, docs/formats.md). Numbers are written with as
/// many digits (up to 17) as it takes to read back the same double. The same calibration gives the same bytes.
std::string CalibrationText(const RigCalibration& calibration, const Provenance& provenance);

/// Writes CalibrationText atomically. Errors: kIo, kDiskFull.
Result<void> WriteCalibration(const std::filesystem::path& path, const RigCalibration& calibration,
                              const Provenance& provenance);

/// A calibration.json as it stands. `records` are its views in order.
struct CalibrationContent {
  RigCalibration calibration;
  Provenance provenance;
  std::vector<CameraRecord> records;
};

/// Reads the text of a calibration.json; `file` names it in messages. Errors: kBadInput (naming the key), kUnsupported
/// (a newer version).
Result<CalibrationContent> ParseCalibration(std::string_view text, const std::string& file);

}  // namespace rigcal
