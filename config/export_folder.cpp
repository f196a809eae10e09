#include "config/export_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>

#include "config/atomic_file.h"
#include "config/read_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A new folder beside `out`, removed at the end of its life with whatever it then holds.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& out)
      : name_((out.parent_path() / fmt::format(".{}.XXXXXX", out.filename().string())).string()) {
    constexpr mode_t kReadableByAll = 0755;  // mkdtemp makes folders of mode 0700
    if (mkdtemp(name_.data()) == nullptr || chmod(name_.c_str(), kReadableByAll) != 0) error_ = errno;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    if (error_ == 0) fs::remove_all(name_, ignored);
  }

  [[nodiscard]] int Error() const { return error_; }
  [[nodiscard]] fs::path Path() const { return name_; }

  /// 0 or an errno. Afterwards the folder has the place and this one holds what stood there, if anything.
  [[nodiscard]] int TakeThePlaceOf(const fs::path& out) const {
    if (rename(name_.c_str(), out.c_str()) == 0) return 0;  // nothing was there, or an empty folder
    if (errno != ENOTEMPTY && errno != EEXIST) return errno;
    return renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, out.c_str(), RENAME_EXCHANGE) == 0 ? 0 : errno;
  }

 private:
  std::string name_;
  int error_ = 0;
};

Result<void> CheckPathsStayInside(const ExportedFiles& files) {
  for (const auto& [name, content] : files) {
    const fs::path path = name;
    const bool is_plain = path.is_relative() && path == path.lexically_normal() && path.has_filename();
    if (!is_plain || *path.begin() == ".." || name == kExportListFile)
      return Fail(ErrorCode::kUnsupported, "the name '{}' cannot be that of an exported file", name);
  }
  return {};
}

std::string ListText(std::string_view format_name, const ExportedFiles& files) {
  Json list = {{"format", format_name}, {"files", Json::object()}};
  for (const auto& [name, content] : files) list["files"][name] = Sha256Hex(content);
  return list.dump(1) + "\n";
}

/// Whether the file below `folder` is one that the list has, unchanged.
bool IsListed(const fs::path& folder, const fs::path& file, const Json& list) {
  const std::string name = file.lexically_relative(folder).generic_string();
  const auto listed = list["files"].find(name);
  if (listed == list["files"].end()) return name == kExportListFile;
  const Result<std::string> bytes = ReadFile(file);
  return bytes && *listed == Sha256Hex(*bytes);
}

Result<void> CheckMayBeReplaced(std::string_view format_name, const fs::path& out) {
  std::error_code error;
  if (!fs::exists(out, error)) return {};
  if (!fs::is_directory(out, error))
    return Fail(ErrorCode::kBadInput, "{}: a folder is needed here, this is a file", out.string());
  if (fs::is_empty(out, error)) return {};
  const Result<std::string> text = ReadFile(out / kExportListFile);
  const Json list = text ? Json::parse(*text, nullptr, false) : Json();
  if (!list.is_object() || list.value("format", Json()) != format_name || !list.value("files", Json()).is_object())
    return Fail(ErrorCode::kBadInput, "{}: holds files and is no export in the format {}, so it is kept", out.string(),
                format_name);
  for (auto entry = fs::recursive_directory_iterator(out, error); entry != fs::end(entry); entry.increment(error)) {
    if (entry->is_directory(error) && !entry->is_symlink(error)) continue;
    if (!IsListed(out, entry->path(), list))
      return Fail(ErrorCode::kBadInput, "{}: is not as an export wrote it, so {} is kept", entry->path().string(),
                  out.string());
  }
  if (error) return WriteFailure(out, error.value());
  return {};
}

Result<void> WriteAll(const ExportedFiles& files, const fs::path& folder) {
  for (const auto& [name, content] : files) {
    const fs::path path = folder / name;
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) return WriteFailure(path.parent_path(), error.value());
    if (Result<void> written = WriteFileAtomically(path, content); !written) return written;
  }
  return {};
}

}  // namespace

Result<void> ReplaceExportFolder(std::string_view format_name, ExportedFiles files, const fs::path& out) {
  if (Result<void> inside = CheckPathsStayInside(files); !inside) return inside;
  std::error_code error;
  // A link is followed, "a/b/" is "a/b", and "." has a name.
  fs::path place = fs::weakly_canonical(fs::absolute(out), error);
  if (error) return WriteFailure(out, error.value());
  if (!place.has_filename()) place = place.parent_path();
  if (Result<void> free = CheckMayBeReplaced(format_name, place); !free) return free;
  if (Result<void> parent = PrepareOutputFolder(place.parent_path()); !parent) return parent;
  files[kExportListFile] = ListText(format_name, files);
  const TemporaryFolder temporary(place);
  if (temporary.Error() != 0) return WriteFailure(place, temporary.Error());
  if (Result<void> written = WriteAll(files, temporary.Path()); !written) return written;
  if (const int failure = temporary.TakeThePlaceOf(place); failure != 0) return WriteFailure(place, failure);
  return {};
}

}  // namespace rigcal
