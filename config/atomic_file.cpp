#include "config/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <system_error>

#include "core/base/descriptor.h"

namespace rigcal {
namespace {

constexpr std::string_view kProbe = "probe";
constexpr std::size_t kRandomPart = 6;  ///< of mkostemp's names

/// A new file beside `path`, removed at the end of its life unless it was renamed to `path`.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::filesystem::path& path)
      : path_(path),
        name_((path.has_parent_path() ? path.parent_path() : ".") /
              fmt::format(".{}.XXXXXX", path.filename().string())) {
    descriptor_ = Descriptor(mkostemp(name_.data(), O_CLOEXEC));
    if (!descriptor_.Open()) open_error_ = errno;
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (descriptor_.Open() && !renamed_) unlink(name_.c_str());
  }

  /// 0 or the errno of the first step that failed.
  int Write(std::string_view bytes) const {
    if (!descriptor_.Open()) return open_error_;
    while (!bytes.empty()) {
      const ssize_t written = write(descriptor_.Number(), bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    constexpr mode_t kReadableByAll = 0644;  // mkostemp makes files of mode 0600
    const int file = descriptor_.Number();
    return fchmod(file, kReadableByAll) != 0 || fsync(file) != 0 ? errno : 0;
  }

  int Rename() {
    if (rename(name_.c_str(), path_.c_str()) != 0) return errno;
    renamed_ = true;
    return 0;
  }

 private:
  std::filesystem::path path_;
  std::string name_;
  Descriptor descriptor_;
  int open_error_ = 0;
  bool renamed_ = false;
};

bool IsAlphanumeric(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

}  // namespace

bool IsTemporaryName(std::string_view name) {
  if (name.size() <= kRandomPart + 2 || name.front() != '.') return false;
  const std::string_view of = name.substr(1, name.size() - kRandomPart - 2), random = name.substr(of.size() + 1);
  if (random.front() != '.' || !std::ranges::all_of(random.substr(1), IsAlphanumeric)) return false;
  const std::size_t dot = of.find_last_of('.');
  return of == kProbe || (dot != std::string_view::npos && dot > 0 && dot + 1 < of.size());
}

int SyncFolder(const std::filesystem::path& folder) {
  const Descriptor opened(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return opened.Open() && fsync(opened.Number()) == 0 ? 0 : errno;
}

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
  const TemporaryFile probe(folder / kProbe);
  if (const int failure = probe.Write(kProbe); failure != 0) return WriteFailure(folder, failure);
  return {};
}

}  // namespace rigcal
