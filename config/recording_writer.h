#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "core/scene/recording.h"

namespace rigcal {

/// Writes a recording into a folder of its own, picture by picture. recording.json is written anew after every step,
/// whole or not at all, so whatever interrupts it leaves a recording that is not closed and lists every picture that
/// was added; at most one picture and one temporary file (".NAME.XXXXXX") lie beside it unlisted.
class RecordingWriter {
 public:
  /// Makes the folder unless it is there and empty. Errors: kBadInput (something is in it already), kIo, kDiskFull.
  static Result<RecordingWriter> Create(const std::filesystem::path& folder, const std::string& id, bool linear);

  /// Give the index for RecordedView. Errors: kBadInput (CheckConsistent), kIo, kDiskFull; nothing is added then.
  Result<int> AddCamera(const RecordedCamera& camera);
  Result<int> AddStop(const RecordedStop& stop);

  /// Writes the picture's file as it is encoded, and then lists it; view.sha256 is filled in. Errors: those of
  /// AddCamera; kBadInput also when the file is there already: nothing is written over.
  Result<void> AddView(RecordedView view, const std::string& picture);

  /// Declares the recording whole. Nothing can be added afterwards. Errors: kIo, kDiskFull.
  Result<void> Close();

  [[nodiscard]] const Recording& Content() const { return recording_; }

 private:
  explicit RecordingWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Writes `changed` and keeps it, or keeps what was.
  Result<void> Save(Recording changed);

  std::filesystem::path folder_;
  Recording recording_;
};

}  // namespace rigcal
