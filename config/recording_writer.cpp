#include "config/recording_writer.h"

#include <utility>

#include "config/atomic_file.h"
#include "config/read_file.h"
#include "config/recording_file.h"
#include "core/base/ensure.h"

namespace rigcal {

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
  if (std::filesystem::exists(path, error))
    return Fail(ErrorCode::kBadInput, "{}: is there already and is not written over", path.string());
  std::filesystem::create_directories(path.parent_path(), error);
  if (Result<void> written = WriteFileAtomically(path, picture); !written) return written;
  Result<void> saved = Save(std::move(changed));
  if (!saved) std::filesystem::remove(path, error);  // so that it can be added again
  return saved;
}

Result<void> RecordingWriter::Close() {
  Recording changed = recording_;
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
