#pragma once

#include <filesystem>

#include "config/provenance.h"
#include "core/base/result.h"
#include "daemon/calibration_run.h"

namespace rigcal {

/// Makes the folder for results and tries that it can be written. Errors: those of PrepareOutputFolder; kBadInput also
/// when it is a recording, which nothing is added to, or when `cameras`, which the run reads, would be replaced.
Result<void> PrepareResultFolder(const std::filesystem::path& folder, const std::filesystem::path& cameras);

/// Writes calibration.json, cameras_par.txt (when no camera has distortion), report.json and patches.ply into `folder`,
/// each whole or not at all. timing.json is left to the caller, because it times this too. Errors: kIo, kDiskFull.
Result<void> WriteRunOutput(const RefinedRig& rig, const Provenance& provenance, const std::filesystem::path& folder);

}  // namespace rigcal
