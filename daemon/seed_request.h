#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "daemon/run_context.h"
#include "daemon/seed_run.h"

namespace rigcal {

/// What `seed` is asked for, on the command line or by a job.
struct SeedRequest {
  std::filesystem::path recording, chart, out;
  std::filesystem::path rig;  ///< rig.toml; empty: every view has a pose of its own
};

/// The whole of `rigcal seed`, and of a job that seeds: a recording and a board in, a result folder out (see
/// WriteSeedOutput, and timing.json). Errors: those of PrepareResultFolder, ReadFile, the parsers, SeedRig and
/// WriteSeedOutput; kBadInput: the recording is not closed.
Result<SeededRig> SeedFiles(const SeedRequest& request, RunContext& context);

}  // namespace rigcal
