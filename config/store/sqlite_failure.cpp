#include "config/store/sqlite_failure.h"

#include <sqlite3.h>

#include <cerrno>

namespace rigcal {
namespace {

/// Codes that SQLite gives for any failure of a system call.
bool IsSystemFailure(int code) {
  return code == SQLITE_IOERR || code == SQLITE_CANTOPEN;
}

}  // namespace

tl::unexpected<Error> StoreFailure(const SQLite::Exception& failure, int system_error,
                                   const std::filesystem::path& file, const char* doing) {
  const int code = failure.getErrorCode() & 0xff;  // the extended codes keep the primary one in their low byte
  const std::string store = file.string();
  const bool no_space = system_error == ENOSPC || system_error == EDQUOT || system_error == EFBIG;
  if (code == SQLITE_FULL || (IsSystemFailure(code) && no_space)) {
    return Fail(ErrorCode::kDiskFull, "{}: {} failed, no space left on the disk", store, doing);
  }
  switch (code) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Fail(ErrorCode::kTimeout, "{}: {} failed, another program holds the store", store, doing);
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return Fail(ErrorCode::kIo, "{}: {} failed, the file may not be written", store, doing);
    case SQLITE_CANTOPEN:
      return Fail(ErrorCode::kIo, "{}: {} failed, the store or its folder may not be written ({})", store, doing,
                  failure.what());
    case SQLITE_NOTADB:
      return Fail(ErrorCode::kBadInput, "{}: is no SQLite database", store);
    case SQLITE_CONSTRAINT:
      return Fail(ErrorCode::kBadInput, "{}: {} was refused: {}", store, doing, failure.what());
    case SQLITE_CORRUPT:
      return Fail(ErrorCode::kIo, "{}: is damaged ({})", store, failure.what());
    default:
      break;
  }
  return Fail(ErrorCode::kIo, "{}: {} failed ({})", store, doing, failure.what());
}

}  // namespace rigcal
