#pragma once

#include <filesystem>
#include <memory>

#include "config/calibration_store.h"

namespace rigcal {

/// Its usual name in a state folder.
inline constexpr const char* kStoreFile = "calibrations.sqlite";

struct SqliteStoreOptions {
  bool create = false;  ///< make the store, with its folder, unless it is there
  /// How long to wait for another program that holds the store, which a publish does for milliseconds. Less than the
  /// two seconds within which a cancelled job stops (issue 5).
  int busy_timeout_ms = 1500;
};

/// Opens a store in a SQLite file (write-ahead log, every commit synced), brought to this program's schema. Errors:
/// kNotFound (and not options.create), kIo: the file or its folder may not be written, kBadInput: another kind of file,
/// kUnsupported: a newer schema, kDiskFull, kTimeout.
Result<std::unique_ptr<CalibrationStore>> OpenSqliteStore(const std::filesystem::path& file,
                                                          const SqliteStoreOptions& options = {});

}  // namespace rigcal
