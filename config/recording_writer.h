#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/scene/recording.h"

namespace rigcal {

/// In which order a recording lists what it holds: stops by id, views by file.
struct RecordingOrder {
  std::vector<std::string> stops, views;
};

/// Writes a recording into a folder of its own, picture by picture. recording.json is written anew after every step,
/// whole or not at all, so whatever interrupts it leaves a recording that is not closed and lists every picture that
/// was added; at most one picture and one temporary file (".NAME.XXXXXX") lie beside it unlisted.
class RecordingWriter {
 public:
  /// Makes the folder unless it is there and empty. Errors: kBadInput (something is in it already), kIo, kDiskFull.
  static Result<RecordingWriter> Create(const std::filesystem::path& folder, const std::string& id, bool linear);

  /// Goes on with a recording that is not closed: what it lists stays. Removes temporary files that were left; a
  /// picture that lies there unlisted is written over when it is added. Errors: those of LoadRecording; kBadInput (it
  /// is closed, or a picture that it lists is not there); kIo.
  static Result<RecordingWriter> Resume(const std::filesystem::path& folder);

  /// Give the index for RecordedView. Errors: kBadInput (CheckConsistent), kIo, kDiskFull; nothing is added then.
  Result<int> AddCamera(const RecordedCamera& camera);
  Result<int> AddStop(const RecordedStop& stop);

  /// Writes the picture's file as it is encoded, and then lists it; view.sha256 is filled in. Errors: those of
  /// AddCamera; kBadInput also when the file is there already: nothing that is listed or foreign is written over.
  Result<void> AddView(RecordedView view, const std::string& picture);

  /// Declares the recording whole. Nothing can be added afterwards. What `order` names is listed first and in its
  /// order, the rest as it was added: a recording that was interrupted can then end as if it had not been. Errors: kIo,
  /// kDiskFull.
  Result<void> Close(const RecordingOrder& order = {});

  [[nodiscard]] const Recording& Content() const { return recording_; }

 private:
  explicit RecordingWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Writes `changed` and keeps it, or keeps what was.
  Result<void> Save(Recording changed);

  std::filesystem::path folder_;
  Recording recording_;
  bool resumed_ = false;
};

}  // namespace rigcal
