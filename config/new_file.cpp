#include "config/new_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>

#include "config/atomic_file.h"
#include "core/base/descriptor.h"

namespace rigcal {
namespace {

tl::unexpected<Error> IsThere(const std::filesystem::path& path) {
  return Fail(ErrorCode::kBadInput, "{}: is there already and is kept", path.string());
}

/// 0 or errno.
int SyncFile(const std::filesystem::path& path) {
  const Descriptor opened(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  return opened.Open() && fsync(opened.Number()) == 0 ? 0 : errno;
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
  const Descriptor made(mkostemp(name.data(), O_CLOEXEC));
  if (!made.Open()) return WriteFailure(path_, errno);
  temporary_ = name;
  return {};
}

Result<void> NewFile::Finish() {
  if (const int error = SyncFile(temporary_); error != 0) return WriteFailure(path_, error);
  // A network file system may not know the flag: there the file that another makes at the same moment is replaced.
  int failed = renameat2(AT_FDCWD, temporary_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE);
  if (failed != 0 && errno == EINVAL) failed = rename(temporary_.c_str(), path_.c_str());
  if (failed != 0 && errno == EEXIST) return IsThere(path_);
  if (failed != 0) return WriteFailure(path_, errno);
  temporary_.clear();
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  if (const int error = SyncFolder(folder); error != 0) return WriteFailure(path_, error);
  return {};
}

}  // namespace rigcal
