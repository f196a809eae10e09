#pragma once

#include <string>

#include "config/calibration_store.h"
#include "core/base/result.h"
#include "core/validate/camera_motion.h"

namespace rigcal {

/// Two revisions of a rig and what moved from one to the other.
struct RevisionDiff {
  RevisionHead before, after;
  CalibrationDifference difference;
};

/// Errors: those of CalibrationStore::Load, ParseCalibration and CompareCalibrations.
Result<RevisionDiff> DiffRevisions(CalibrationStore& store, const std::string& rig, int before, int after);

/// A line for each camera, for people.
std::string DiffText(const RevisionDiff& diff);
/// The same as JSON.
std::string DiffJson(const RevisionDiff& diff);

}  // namespace rigcal
