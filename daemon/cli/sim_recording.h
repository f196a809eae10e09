#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "sim_fixtures/truth_file.h"

namespace rigcal {

/// Declares the pictures that WriteSimFolder wrote to be a closed recording, with what the studio's devices know: the
/// table's angles as commanded (a table without an encoder), or, for a gantry, poses of a flange that is the camera.
/// Before that writes a turntable's rig.toml: as exact as the studio's options have it, as a table is by default where
/// they have no error. Errors: kIo, kDiskFull.
Result<void> WriteSimRecording(const sim::Studio& studio, const sim::ShotOptions& shot,
                               const std::filesystem::path& folder);

}  // namespace rigcal
