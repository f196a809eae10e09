#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/rig_devices.h"

namespace rigcal {

struct PruneOptions {
  KeepRule rule;
  std::set<std::string> needed;  ///< ids, or names of folders, of recordings that somebody wants to keep: they never go
  std::set<std::string> of_revisions;  ///< RecordingsOfRevisions: they never go either
  bool dry_run = false;                ///< says what would go, and touches nothing
};

/// What pruning sees of the machine, so that tests can hold it.
struct PruneSurroundings {
  std::chrono::system_clock::time_point now;
  std::function<Result<double>(const std::filesystem::path&)> free_bytes;  ///< of the disk that holds the folder
};

/// Now, and the disk as it is.
PruneSurroundings RealSurroundings();

struct PrunedRecording {
  std::filesystem::path folder;
  std::string id;
  std::string reason;  ///< which part of the rule, its number and its limit
  double bytes = 0;    ///< of its files
};

struct PruneReport {
  std::vector<PrunedRecording> gone;  ///< oldest first; with dry_run those that would go
  int num_left = 0;                   ///< closed recordings that are still there
  std::vector<std::string> remarks;   ///< what was not touched and why; what of the rule is not met
  std::optional<Error> failure;       ///< why it ended early: kIo, kCancelled
};

/// Applies the rule to the recordings that lie in `folder` itself, oldest first: by the time of the last picture, else
/// by that of recording.json. Goes: a closed recording that is not needed, in a folder with nothing in it that is not
/// the recording's. Stays: everything else. A recording first gets the name of a file that is to be deleted
/// (".NAME.pruned"), then loses recording.json, then the rest; what an interruption has left of it goes with the next
/// call. Free space is reckoned from what it was and what the recordings hold, for a disk may be slow to tell. Errors:
/// kNotFound (no such folder), kIo; once something went, in PruneReport::failure.
Result<PruneReport> PruneRecordings(const std::filesystem::path& folder, const PruneOptions& options,
                                    const PruneSurroundings& surroundings, const std::stop_token& stop);

}  // namespace rigcal
