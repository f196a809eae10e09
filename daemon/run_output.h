#pragma once

#include <filesystem>

#include "config/provenance.h"
#include "core/base/result.h"
#include "daemon/calibration_run.h"

namespace rigcal {

/// Writes calibration.json, cameras_par.txt (when no camera has distortion), report.json and patches.ply into `folder`,
/// each whole or not at all. timing.json is left to the caller, because it times this too. Errors: kIo, kDiskFull.
Result<void> WriteRunOutput(const RefinedRig& rig, const Provenance& provenance, const std::filesystem::path& folder);

}  // namespace rigcal
