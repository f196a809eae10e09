#pragma once

#include <filesystem>
#include <memory>

#include "config/job_journal.h"

namespace rigcal {

/// Its usual name in a state folder.
inline constexpr const char* kJournalFile = "jobs.sqlite";

/// Opens a journal in a SQLite file (write-ahead log, every commit synced), made with its folder unless it is there.
/// Errors: kIo: it may not be written; kBadInput: another kind of file; kUnsupported: a newer schema; kDiskFull,
/// kTimeout.
Result<std::unique_ptr<JobJournal>> OpenSqliteJournal(const std::filesystem::path& file);

}  // namespace rigcal
