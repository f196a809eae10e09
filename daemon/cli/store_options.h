#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "config/calibration_store.h"
#include "config/publish_files.h"
#include "core/base/result.h"

namespace rigcal {

/// Which rig of which store a command is about, as given on the command line.
struct StoreChoice {
  std::filesystem::path state = "/var/lib/rigcal";  ///< the service's StateDirectory
  std::string rig;                                  ///< empty: the only one in the store
};

/// Declares --state and --rig.
void AddStoreOptions(CLI::App& command, StoreChoice& choice);

/// A rig of an opened store.
struct RigStore {
  std::unique_ptr<CalibrationStore> store;
  std::string rig;
};

/// Errors: those of OpenSqliteStore; kNotFound: the store has no such rig; kBadInput: it has several and none is named.
Result<RigStore> OpenRigStore(const StoreChoice& choice);

/// Whether an argument "REV|FILE" names a file: it has a '/' or there is a file of that name.
bool NamesFile(const std::string& argument);

/// The number of a revision. Errors: kBadInput.
Result<int> RevisionNumber(const std::string& argument);

/// What is in force, as compare-and-swap expects it.
Result<std::optional<int>> NumberInForce(RigStore& opened);

/// Who runs this program: the user's name, else "uid 1000".
std::string UserName();

/// Now, as revisions and events have it.
std::string NowText();

}  // namespace rigcal
