#include "config/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace rigcal {
namespace {

/// A new file beside `path`, removed at the end of its life unless it was renamed to `path`.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& path)
      : path_(path),
        name_((path.has_parent_path() ? path.parent_path() : ".") /
              fmt::format(".{}.XXXXXX", path.filename().string())) {
    descriptor_ = mkostemp(name_.data(), O_CLOEXEC);
    if (descriptor_ < 0) open_error_ = errno;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_ >= 0) close(descriptor_);
    if (descriptor_ >= 0 && !renamed_) unlink(name_.c_str());
  }

  /// 0 or the errno of the first step that failed.
  int Write(std::string_view bytes) const {
    if (descriptor_ < 0) return open_error_;
    while (!bytes.empty()) {
      const ssize_t written = write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    constexpr mode_t kReadableByAll = 0644;  // mkostemp makes files of mode 0600
    return fchmod(descriptor_, kReadableByAll) != 0 || fsync(descriptor_) != 0 ? errno : 0;
  }

  int Rename() {
    if (rename(name_.c_str(), path_.c_str()) != 0) return errno;
    renamed_ = true;
    return 0;
  }

 private:
  std::filesystem::path path_;
  std::string name_;
  int descriptor_ = -1;
  int open_error_ = 0;
  bool renamed_ = false;
};

}  // namespace

tl::unexpected<Error> WriteFailure(const std::filesystem::path& path, int error) {
  if (error == ENOSPC || error == EDQUOT)
    return Fail(ErrorCode::kDiskFull, "{}: no space left on the disk", path.string());
  return Fail(ErrorCode::kIo, "{}: cannot be written ({})", path.string(), std::generic_category().message(error));
}

Result<void> WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes) {
  TemporaryFile file(path);
  if (const int error = file.Write(bytes); error != 0) return WriteFailure(path, error);
  if (const int error = file.Rename(); error != 0) return WriteFailure(path, error);
  return {};
}

Result<void> PrepareOutputFolder(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    return Fail(ErrorCode::kBadInput, "{}: a folder is needed here, this is a file", folder.string());
  std::filesystem::create_directories(folder, error);
  if (error) return WriteFailure(folder, error.value());
  const TemporaryFile probe(folder / "probe");
  if (const int failure = probe.Write("probe"); failure != 0) return WriteFailure(folder, failure);
  return {};
}

}  // namespace rigcal
