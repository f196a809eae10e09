#include "config/recording_writer.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "config/atomic_file.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "core/base/ensure.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// Removes what WriteFileAtomically leaves when it is killed.
Result<void> RemoveTemporaryFiles(const fs::path& folder) {
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file(error) && IsTemporaryName(it->path().filename().string())) {
      left.push_back(it->path());
    }
  }
  for (const fs::path& path : left) fs::remove(path, error);
  if (error)
    return Fail(ErrorCode::kIo, "{}: cannot be cleared of temporary files ({})", folder.string(), error.message());
  return {};
}

/// Places in `items` of those that `wanted` names, in its order, then of the others.
template <typename Item>
std::vector<int> PlacesInOrder(const std::vector<Item>& items, const std::vector<std::string>& wanted,
                               std::string Item::*name) {
  std::vector<int> places(items.size());
  std::iota(places.begin(), places.end(), 0);
  const auto rank = [&](int place) { return std::ranges::find(wanted, items[place].*name) - wanted.begin(); };
  std::ranges::stable_sort(places, {}, rank);
  return places;
}

Recording InOrder(const Recording& recording, const RecordingOrder& order) {
  Recording sorted = recording;
  const std::vector<int> stops = PlacesInOrder(recording.stops, order.stops, &RecordedStop::id);
  const std::vector<int> views = PlacesInOrder(recording.views, order.views, &RecordedView::file);
  std::vector<int> new_place(stops.size());
  for (std::size_t s = 0; s < stops.size(); ++s) {
    sorted.stops[s] = recording.stops[stops[s]];
    new_place[stops[s]] = static_cast<int>(s);
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    sorted.views[v] = recording.views[views[v]];
    if (sorted.views[v].stop) sorted.views[v].stop = new_place[*sorted.views[v].stop];
  }
  return sorted;
}

}  // namespace

Result<RecordingWriter> RecordingWriter::Create(const std::filesystem::path& folder, const std::string& id,
                                                bool linear) {
  if (Result<void> ready = PrepareOutputFolder(folder); !ready) return Fail(ready.error());
  std::error_code error;
  if (!std::filesystem::is_empty(folder, error))
    return Fail(ErrorCode::kBadInput, "{}: a new recording needs an empty folder, this one is not", folder.string());
  RecordingWriter writer(folder);
  if (Result<void> saved = writer.Save({.id = id, .linear = linear}); !saved) return Fail(saved.error());
  return writer;
}

Result<RecordingWriter> RecordingWriter::Resume(const std::filesystem::path& folder) {
  Result<Recording> recording = LoadRecording(folder);
  if (!recording) return Fail(recording.error());
  if (recording->closed) {
    return Fail(ErrorCode::kBadInput, "{}: the recording is closed, nothing is missing from it", folder.string());
  }
  std::error_code error;
  for (const RecordedView& view : recording->views) {
    if (!fs::exists(folder / view.file, error)) {
      return Fail(ErrorCode::kBadInput, "{}: is listed in the recording and not there", (folder / view.file).string());
    }
  }
  if (Result<void> cleared = RemoveTemporaryFiles(folder); !cleared) return Fail(cleared.error());
  RecordingWriter writer(folder);
  writer.recording_ = std::move(*recording);
  writer.resumed_ = true;
  return writer;
}

Result<int> RecordingWriter::AddCamera(const RecordedCamera& camera) {
  Recording changed = recording_;
  changed.cameras.push_back(camera);
  if (Result<void> saved = Save(std::move(changed)); !saved) return Fail(saved.error());
  return static_cast<int>(recording_.cameras.size()) - 1;
}

Result<int> RecordingWriter::AddStop(const RecordedStop& stop) {
  Recording changed = recording_;
  changed.stops.push_back(stop);
  if (Result<void> saved = Save(std::move(changed)); !saved) return Fail(saved.error());
  return static_cast<int>(recording_.stops.size()) - 1;
}

Result<void> RecordingWriter::AddView(RecordedView view, const std::string& picture) {
  Ensure(!recording_.closed, "a closed recording is not changed");
  const std::filesystem::path path = folder_ / view.file;
  view.sha256 = Sha256Hex(picture);
  Recording changed = recording_;
  changed.views.push_back(std::move(view));
  if (Result<void> consistent = CheckConsistent(changed); !consistent) return consistent;
  std::error_code error;
  // In a resumed recording this is the picture that was interrupted before it was listed: CheckConsistent has seen that
  // it is none of those that are.
  if (!resumed_ && std::filesystem::exists(path, error))
    return Fail(ErrorCode::kBadInput, "{}: is there already and is not written over", path.string());
  std::filesystem::create_directories(path.parent_path(), error);
  if (Result<void> written = WriteFileAtomically(path, picture); !written) return written;
  Result<void> saved = Save(std::move(changed));
  if (!saved) std::filesystem::remove(path, error);  // so that it can be added again
  return saved;
}

Result<void> RecordingWriter::Close(const RecordingOrder& order) {
  Recording changed = InOrder(recording_, order);
  changed.closed = true;
  return Save(std::move(changed));
}

Result<void> RecordingWriter::Save(Recording changed) {
  Ensure(!recording_.closed, "a closed recording is not changed");
  if (Result<void> consistent = CheckConsistent(changed); !consistent) return consistent;
  if (Result<void> written = WriteFileAtomically(folder_ / kRecordingFile, RecordingText(changed)); !written)
    return written;
  recording_ = std::move(changed);
  return {};
}

}  // namespace rigcal
