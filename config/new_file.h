#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace rigcal {

/// A new file that a library writes by its path: it is written beside its place, and is there whole or not at all. What
/// is there already is kept.
class NewFile {
 public:
  explicit NewFile(std::filesystem::path path) : path_(std::move(path)) {}
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile();

  /// Makes the temporary file, empty. Errors: kBadInput: `path` is there already; kIo, kDiskFull.
  Result<void> Begin();
  [[nodiscard]] const std::filesystem::path& TemporaryPath() const { return temporary_; }
  /// Syncs what was written and gives it its name. Errors: as Begin.
  Result<void> Finish();

 private:
  std::filesystem::path path_, temporary_;  ///< temporary_: empty before Begin and after Finish
};

}  // namespace rigcal
