#pragma once

#include <SQLiteCpp/Database.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// The schema that this program writes (PRAGMA user_version).
inline constexpr int kStoreSchema = 2;

/// Brings a database to kStoreSchema step by step, all steps or none; an empty one becomes a store. Throws
/// SQLite::Exception. Errors: kUnsupported: a newer schema; kBadInput: a database that is no store of rigcal.
Result<void> Migrate(SQLite::Database& database, const std::filesystem::path& file);

/// Tables, indices and triggers that differ from those of a store as Migrate makes it, a sentence each. Throws
/// SQLite::Exception.
std::vector<std::string> SchemaDifferences(SQLite::Database& database);

}  // namespace rigcal
