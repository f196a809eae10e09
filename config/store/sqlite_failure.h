#pragma once

#include <SQLiteCpp/Exception.h>

#include <filesystem>

#include "core/base/result.h"

namespace rigcal {

/// The Error for what SQLite says about a store. `system_error` is errno as SQLite left it, set to 0 before: a quota
/// that is used up is an I/O error like any other to SQLite. `doing` is what was tried ("publishing"). kDiskFull;
/// kTimeout: another held the store; kBadInput: a constraint of the tables, or a file that is no database; kIo else.
tl::unexpected<Error> StoreFailure(const SQLite::Exception& failure, int system_error,
                                   const std::filesystem::path& file, const char* doing);

}  // namespace rigcal
