#include "config/staged_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "config/atomic_file.h"
#include "config/export.h"
#include "config/read_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHiddenFolder = ".files-";
/// What a crash leaves of WriteFileAtomically and PrepareOutputFolder.
constexpr std::array<std::string_view, 2> kLeftovers = {".current.json.", ".probe."};
/// How long another publisher may hold the folder: it writes a few megabytes; a slow network disk takes seconds.
constexpr double kLockTimeoutS = 30, kLockPauseS = 0.01;

constexpr auto kFolderMode = fs::perms::owner_all | fs::perms::group_read | fs::perms::group_exec |
                             fs::perms::others_read | fs::perms::others_exec;
constexpr auto kFileMode =
    fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read | fs::perms::others_read;

/// Whatever the umask: others read the files.
Result<void> LetAllRead(const fs::path& folder) {
  std::error_code error;
  fs::permissions(folder, kFolderMode, error);
  if (error) return WriteFailure(folder, error.value());
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    fs::permissions(it->path(), it->is_directory() ? kFolderMode : kFileMode, error);
    if (error) return WriteFailure(it->path(), error.value());
  }
  if (error) return WriteFailure(folder, error.value());
  return {};
}

/// What the folder's current.json says was written beside it. Empty when there is none or it is not ours.
std::vector<std::string> NamesShown(const fs::path& folder) {
  std::vector<std::string> names;
  const Result<std::string> text = ReadFile(folder / kCurrentFile);
  if (!text) return names;
  try {
    const auto current = nlohmann::json::parse(*text);
    for (const auto& file : current.at("revision").at("files")) {
      const auto name = file.at("name").get<std::string>();
      if (!name.empty() && name[0] != '.' && name.find('/') == std::string::npos) names.push_back(name);
    }
  } catch (const nlohmann::json::exception&) {
    names.clear();
  }
  return names;
}

}  // namespace

std::string PublishedName(const std::string& format) {
  const FormatEntry* entry = EntryNamed(format);
  return entry == nullptr || entry->published_name.empty() ? format : std::string(entry->published_name);
}

StagedFiles::~StagedFiles() {
  std::error_code ignored;
  if (!staged_.empty() && !linked_) fs::remove_all(staged_, ignored);
}

Result<void> StagedFiles::Lock(Clock& clock, const std::stop_token& stop) {
  std::error_code error;
  const bool is_new = !fs::exists(folder_, error);
  if (auto ready = PrepareOutputFolder(folder_); !ready) return ready;
  if (is_new) fs::permissions(folder_, kFolderMode, error);
  lock_ = Descriptor(open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock_.Open()) return WriteFailure(folder_, errno);
  const double begin_s = clock.NowS();
  while (flock(lock_.Number(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) return WriteFailure(folder_, errno);
    if (clock.NowS() - begin_s > kLockTimeoutS) {
      return Fail(ErrorCode::kTimeout, "{}: another publisher has held the folder for {} s", folder_.string(),
                  kLockTimeoutS);
    }
    if (!clock.Wait(kLockPauseS, stop)) {
      return Fail(ErrorCode::kCancelled, "{}: publishing there was stopped on request", folder_.string());
    }
  }
  return {};
}

Result<std::vector<std::string>> StagedFiles::Write(const RigCalibration& calibration,
                                                    const std::vector<PublishedFormat>& formats) {
  std::vector<std::string> notes;
  if (formats.empty()) return notes;
  std::string pattern = (folder_ / (std::string(kHiddenFolder) + "XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr) return WriteFailure(folder_, errno);
  staged_ = pattern;
  for (const PublishedFormat& wanted : formats) {
    const FormatEntry* entry = EntryNamed(wanted.format);
    if (entry == nullptr) return Fail(ErrorCode::kBadInput, "'{}' is no format to publish in", wanted.format);
    const std::string name = PublishedName(wanted.format);
    if (std::ranges::find(names_, name) != names_.end()) {
      return Fail(ErrorCode::kBadInput, "{}: the format '{}' is asked for twice", folder_.string(), wanted.format);
    }
    if (auto free = CheckPlace(name, entry->is_folder); !free) return Fail(free.error());
    const auto exported = Export(calibration, {entry->format, wanted.undistorted}, staged_ / name);
    if (!exported) return Fail(exported.error());
    for (const std::string& note : *exported) notes.push_back(fmt::format("{}: {}", name, note));
    names_.push_back(name);
  }
  if (auto readable = LetAllRead(staged_); !readable) return Fail(readable.error());
  return notes;
}

Result<void> StagedFiles::CheckPlace(const std::string& name, bool is_folder) const {
  const fs::path place = folder_ / name;
  std::error_code error;
  const fs::file_type there = fs::symlink_status(place, error).type();
  const fs::path link = fs::read_symlink(place, error);
  const bool own_link = !link.empty() && link.begin()->string().starts_with(kHiddenFolder);
  if (there == fs::file_type::not_found || (is_folder ? own_link : there == fs::file_type::regular)) return {};
  return Fail(ErrorCode::kBadInput, "{}: was not published by rigcal, and is kept", place.string());
}

Result<void> StagedFiles::ShowFolder(const std::string& name) {
  const fs::path shown = folder_ / name, link = folder_ / fmt::format(".{}.link", name);
  std::error_code error;
  const fs::path before = fs::read_symlink(shown, error);
  if (!error) shown_before_ = before.begin()->string();
  fs::remove(link, error);  // of a crash
  fs::create_directory_symlink(staged_.filename() / name, link, error);
  if (error) return WriteFailure(link, error.value());
  fs::rename(link, shown, error);
  if (error) return WriteFailure(shown, error.value());
  linked_ = true;
  return {};
}

Result<void> StagedFiles::Show(const std::string& current_text) {
  const std::vector<std::string> names_before = NamesShown(folder_);
  for (const std::string& name : names_) {
    if (fs::is_directory(staged_ / name)) {
      if (auto shown = ShowFolder(name); !shown) return shown;
      continue;
    }
    std::error_code error;
    fs::rename(staged_ / name, folder_ / name, error);
    if (error) return WriteFailure(folder_ / name, error.value());
  }
  if (auto written = WriteFileAtomically(folder_ / kCurrentFile, current_text); !written) return written;
  std::error_code ignored;
  for (const std::string& name : names_before) {
    if (std::ranges::find(names_, name) == names_.end()) fs::remove(folder_ / name, ignored);
  }
  if (fsync(lock_.Number()) != 0) return WriteFailure(folder_, errno);
  RemoveOldFolders();
  return {};
}

void StagedFiles::RemoveOldFolders() const {
  std::error_code error;
  std::set<std::string> kept = {staged_.filename().string(), shown_before_};
  std::vector<fs::path> hidden;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
    if (entry.is_symlink(error)) {
      const fs::path target = fs::read_symlink(entry.path(), error);
      if (!target.empty()) kept.insert(target.begin()->string());
      continue;
    }
    const std::string name = entry.path().filename().string();
    const auto begins = [&name](std::string_view prefix) { return name.starts_with(prefix); };
    if (begins(kHiddenFolder) || std::ranges::any_of(kLeftovers, begins)) hidden.push_back(entry.path());
  }
  for (const fs::path& path : hidden) {
    if (!kept.contains(path.filename().string())) fs::remove_all(path, error);
  }
}

}  // namespace rigcal
