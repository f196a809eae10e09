#include "config/recording_prune.h"

#include <algorithm>
#include <system_error>

#include "config/atomic_file.h"
#include "config/read_file.h"
#include "config/recording_check.h"
#include "config/recording_file.h"
#include "config/utc_text.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using TimePoint = std::chrono::system_clock::time_point;

constexpr double kSecondsPerDay = 86400, kBytesPerGb = 1e9;
constexpr std::string_view kDoomedSuffix = ".pruned";

/// A closed recording.
struct Candidate {
  fs::path folder;
  std::string id;
  TimePoint taken;
  double bytes = 0;
  const char* why_needed = nullptr;  ///< null: it is not
  bool foreign = false;              ///< holds something that is not its own
};

struct Found {
  std::vector<Candidate> recordings;  ///< oldest first
  std::vector<fs::path> doomed;       ///< what an interruption has left
  std::vector<std::string> remarks;
};

TimePoint TimeOf(const Recording& recording, const fs::path& folder) {
  std::optional<TimePoint> last;
  for (const RecordedView& view : recording.views) {
    const auto taken = view.taken_at ? TimeFromUtc(*view.taken_at) : std::nullopt;
    if (taken && (!last || *taken > *last)) last = taken;
  }
  if (last) return *last;
  std::error_code error;
  const auto written = fs::last_write_time(folder / kRecordingFile, error);
  if (error) return TimePoint::max();  // what is not known to be old is not
  return std::chrono::time_point_cast<std::chrono::system_clock::duration>(fs::file_time_type::clock::to_sys(written));
}

double BytesBelow(const fs::path& folder) {
  double bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code unknown;
    if (it->symlink_status(unknown).type() == fs::file_type::regular)
      bytes += static_cast<double>(it->file_size(unknown));
  }
  return bytes;
}

/// Null where nobody needs it.
const char* WhyNeeded(const fs::path& folder, const Recording& recording, const PruneOptions& options) {
  if (options.needed.contains(recording.id) || options.needed.contains(folder.filename().string()))
    return "it is needed";
  constexpr const char* kOfRevision = "a revision was made from it";
  if (options.of_revisions.contains(recording.id)) return kOfRevision;
  const Result<std::string> text = ReadFile(folder / kRecordingFile);
  if (!text) return "recording.json cannot be read any more";
  return options.of_revisions.contains(Sha256Hex(*text)) ? kOfRevision : nullptr;
}

/// A folder below the one that is pruned, as far as it is a recording.
void LookAt(const fs::path& folder, const PruneOptions& options, Found& found) {
  std::error_code error;
  if (!fs::exists(folder / kRecordingFile, error)) return;
  const Result<Recording> recording = LoadRecording(folder);
  if (!recording) {
    found.remarks.push_back(fmt::format("{}: left alone: {}", folder.string(), recording.error().message));
    return;
  }
  if (!recording->closed) {
    found.remarks.push_back(fmt::format("{}: left alone: the recording is not closed", folder.string()));
    return;
  }
  Candidate candidate{.folder = folder,
                      .id = recording->id,
                      .taken = TimeOf(*recording, folder),
                      .bytes = BytesBelow(folder),
                      .why_needed = WhyNeeded(folder, *recording, options)};
  for (const std::string& file : ForeignFiles(folder, *recording)) {
    if (candidate.foreign || IsTemporaryName(fs::path(file).filename().string())) continue;
    candidate.foreign = true;
    found.remarks.push_back(fmt::format("{}: left alone: {} is not part of the recording", folder.string(), file));
  }
  found.recordings.push_back(std::move(candidate));
}

Result<Found> Find(const fs::path& folder, const PruneOptions& options, const std::stop_token& stop) {
  Found found;
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code unknown;
    if (it->symlink_status(unknown).type() == fs::file_type::directory) folders.push_back(it->path());
  }
  if (error) return Fail(ErrorCode::kNotFound, "{}: cannot be read as a folder ({})", folder.string(), error.message());
  std::sort(folders.begin(), folders.end());
  for (const fs::path& inside : folders) {
    if (stop.stop_requested()) return Fail(ErrorCode::kCancelled, "pruning {} was cancelled", folder.string());
    const std::string name = inside.filename().string();
    if (name.starts_with('.') && name.ends_with(kDoomedSuffix))
      found.doomed.push_back(inside);
    else
      LookAt(inside, options, found);
  }
  std::stable_sort(found.recordings.begin(), found.recordings.end(),
                   [](const Candidate& a, const Candidate& b) { return a.taken < b.taken; });
  return found;
}

/// What the rule says against a recording; empty: nothing.
std::string WhyGo(const KeepRule& rule, const Candidate& candidate, TimePoint now, int num_left, double free_bytes) {
  const double age_days = std::chrono::duration<double>(now - candidate.taken).count() / kSecondsPerDay;
  if (rule.max_age_days && age_days > *rule.max_age_days)
    return fmt::format("{:.1f} days old (limit {:.6g})", age_days, *rule.max_age_days);
  if (rule.max_count && num_left > *rule.max_count)
    return fmt::format("the oldest of {} recordings (limit {})", num_left, *rule.max_count);
  if (rule.min_free_bytes && free_bytes < *rule.min_free_bytes)
    return fmt::format("{:.3f} GB of the disk are free (limit {:.6g})", free_bytes / kBytesPerGb,
                       *rule.min_free_bytes / kBytesPerGb);
  return "";
}

/// Decides what goes, before anything does.
PruneReport Plan(const Found& found, const PruneOptions& options, TimePoint now, double free_bytes) {
  PruneReport plan{.num_left = static_cast<int>(found.recordings.size()), .remarks = found.remarks};
  for (const Candidate& candidate : found.recordings) {
    const std::string why = WhyGo(options.rule, candidate, now, plan.num_left, free_bytes);
    if (why.empty() || candidate.foreign) continue;
    if (candidate.why_needed != nullptr) {
      plan.remarks.push_back(
          fmt::format("{}: {}, stays because {}", candidate.folder.string(), why, candidate.why_needed));
      continue;
    }
    plan.gone.push_back({candidate.folder, candidate.id, why, candidate.bytes});
    --plan.num_left;
    free_bytes += candidate.bytes;
  }
  for (const std::string& needed : options.needed) {
    const bool known = std::ranges::any_of(found.recordings, [&](const Candidate& candidate) {
      return candidate.id == needed || candidate.folder.filename() == needed;
    });
    if (!known) plan.remarks.push_back(fmt::format("there is no closed recording '{}' to be kept", needed));
  }
  if (options.rule.max_count && plan.num_left > *options.rule.max_count)
    plan.remarks.push_back(
        fmt::format("{} recordings stay (limit {}): nothing else may go", plan.num_left, *options.rule.max_count));
  if (options.rule.min_free_bytes && free_bytes < *options.rule.min_free_bytes)
    plan.remarks.push_back(fmt::format("{:.3f} GB of the disk are free (limit {:.6g}): nothing else may go",
                                       free_bytes / kBytesPerGb, *options.rule.min_free_bytes / kBytesPerGb));
  return plan;
}

tl::unexpected<Error> RemovalFailure(const fs::path& path, const std::string& reason) {
  return Fail(ErrorCode::kIo, "{}: cannot be removed ({})", path.string(), reason);
}

/// A folder that already has the name of one to be removed.
Result<void> RemoveDoomed(const fs::path& folder) {
  std::error_code error;
  fs::remove(folder / kRecordingFile, error);
  if (error) return RemovalFailure(folder, error.message());
  SyncFolder(folder);  // before the rest goes; where it cannot be synced the name still says what it is
  fs::remove_all(folder, error);
  if (error) return RemovalFailure(folder, error.message());
  return {};
}

Result<void> RemoveRecording(const fs::path& folder) {
  const fs::path doomed = folder.parent_path() / fmt::format(".{}{}", folder.filename().string(), kDoomedSuffix);
  std::error_code error;
  fs::rename(folder, doomed, error);
  if (error) return RemovalFailure(folder, error.message());
  SyncFolder(folder.parent_path());
  return RemoveDoomed(doomed);
}

/// Does what was planned, and ends at the first failure; the report then has what went.
void Carry(PruneReport& report, const std::vector<fs::path>& doomed, const std::stop_token& stop) {
  for (const fs::path& folder : doomed) {
    if (stop.stop_requested()) break;
    if (const Result<void> removed = RemoveDoomed(folder); !removed && !report.failure)
      report.failure = removed.error();
  }
  std::size_t num_gone = 0;
  for (; num_gone < report.gone.size() && !report.failure; ++num_gone) {
    const fs::path& folder = report.gone[num_gone].folder;
    Result<void> removed;
    if (stop.stop_requested())
      removed = Fail(ErrorCode::kCancelled, "{}: pruning was cancelled before it went", folder.string());
    else
      removed = RemoveRecording(folder);
    if (removed) continue;
    report.failure = removed.error();
    break;
  }
  report.num_left += static_cast<int>(report.gone.size() - num_gone);
  report.gone.resize(num_gone);
}

}  // namespace

PruneSurroundings RealSurroundings() {
  return {std::chrono::system_clock::now(), [](const fs::path& folder) -> Result<double> {
            std::error_code error;
            const fs::space_info space = fs::space(folder, error);
            if (error) return Fail(ErrorCode::kIo, "{}: free space is unknown ({})", folder.string(), error.message());
            return static_cast<double>(space.available);
          }};
}

Result<PruneReport> PruneRecordings(const fs::path& folder, const PruneOptions& options,
                                    const PruneSurroundings& surroundings, const std::stop_token& stop) {
  const Result<Found> found = Find(folder, options, stop);
  if (!found) return Fail(found.error());
  const Result<double> free_bytes = surroundings.free_bytes(folder);
  if (!free_bytes) return Fail(free_bytes.error());
  PruneReport report = Plan(*found, options, surroundings.now, *free_bytes);
  if (!options.dry_run) Carry(report, found->doomed, stop);
  return report;
}

}  // namespace rigcal
