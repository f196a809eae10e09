#include "daemon/rig_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "config/read_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> LockFailure(const fs::path& path, int error) {
  return Fail(ErrorCode::kIo, "{}: the rig cannot be locked ({})", path.string(),
              std::generic_category().message(error));
}

/// Lines of the lock file: process, what it does, what to do instead.
std::string TextOf(const RigHolder& holder) {
  return fmt::format("{}\n{}\n{}\n", getpid(), holder.what, holder.ask_instead);
}

std::string LineOf(const std::string& text, int number) {
  std::size_t begin = 0;
  for (int i = 0; i < number && begin != std::string::npos; ++i) {
    const std::size_t end = text.find('\n', begin);
    begin = end == std::string::npos ? end : end + 1;
  }
  return begin == std::string::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
}

tl::unexpected<Error> Held(const fs::path& rig_file, const std::string& text) {
  const std::string instead = LineOf(text, 2);
  return Fail(ErrorCode::kDevice, "{}: the rig is held by process {} ({}){}", rig_file.string(), LineOf(text, 0),
              LineOf(text, 1), instead.empty() ? "" : "; ask it with: " + instead);
}

}  // namespace

Result<RigLock> RigLock::Take(const fs::path& run_folder, const fs::path& rig_file, const RigHolder& holder) {
  std::error_code error;
  fs::create_directories(run_folder, error);
  if (error) return LockFailure(run_folder, error.value());
  constexpr std::size_t kDigits = 16;  // enough to tell the rig files of a machine apart
  const std::string name = fs::weakly_canonical(rig_file, error).string();
  const fs::path path = run_folder / fmt::format("rig-{}.lock", Sha256Hex(name).substr(0, kDigits));
  constexpr mode_t kReadableByAll = 0644;
  // A link is not followed: in the temporary folder it may be another user's, and what it leads to would be emptied.
  Descriptor file(open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, kReadableByAll));
  const int why_not = file.Open() ? 0 : errno;
  // Another user's file, the service's: who may not write it is told at least who holds the rig.
  if (why_not == EACCES) file = Descriptor(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file.Open()) return LockFailure(path, why_not);
  if (flock(file.Number(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return LockFailure(path, errno);
    const Result<std::string> text = ReadFile(path);
    return Held(rig_file, text ? *text : "");
  }
  if (why_not != 0) return LockFailure(path, why_not);
  const std::string text = TextOf(holder);
  const bool written = ftruncate(file.Number(), 0) == 0 &&
                       write(file.Number(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (!written) return LockFailure(path, errno);
  return RigLock(std::move(file));
}

fs::path DefaultRunFolder() {
  if (const char* folder = std::getenv("RIGCAL_RUN_DIR"); folder != nullptr && *folder != '\0') return folder;
  const fs::path system = "/run/rigcal";
  if (access(system.c_str(), W_OK) == 0) return system;
  std::error_code error;
  return fs::temp_directory_path(error) / fmt::format("rigcal-{}", getuid());
}

}  // namespace rigcal
