#include "config/new_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>

#include "config/atomic_file.h"

namespace rigcal {
namespace {

tl::unexpected<Error> IsThere(const std::filesystem::path& path) {
  return Fail(ErrorCode::kBadInput, "{}: is there already and is kept", path.string());
}

/// 0 or errno.
int Sync(const std::filesystem::path& path, int flags) {
  const int descriptor = open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int error = fsync(descriptor) != 0 ? errno : 0;
  close(descriptor);
  return error;
}

}  // namespace

NewFile::~NewFile() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

Result<void> NewFile::Begin() {
  std::error_code ignored;
  if (std::filesystem::exists(path_, ignored)) return IsThere(path_);
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  std::string name = (folder / fmt::format(".{}.XXXXXX", path_.filename().string())).string();
  const int descriptor = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) return WriteFailure(path_, errno);
  close(descriptor);
  temporary_ = name;
  return {};
}

Result<void> NewFile::Finish() {
  if (const int error = Sync(temporary_, O_RDONLY); error != 0) return WriteFailure(path_, error);
  // A network file system may not know the flag: there the file that another makes at the same moment is replaced.
  int failed = renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE);
  if (failed != 0 && errno == EINVAL) failed = rename(temporary_.c_str(), path_.c_str());
  if (failed != 0 && errno == EEXIST) return IsThere(path_);
  if (failed != 0) return WriteFailure(path_, errno);
  temporary_.clear();
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  if (const int error = Sync(folder, O_RDONLY | O_DIRECTORY); error != 0) return WriteFailure(path_, error);
  return {};
}

}  // namespace rigcal
