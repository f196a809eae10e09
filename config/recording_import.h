#pragma once

#include <filesystem>
#include <string>

#include "core/base/execution.h"
#include "core/scene/recording.h"

namespace rigcal {

/// Pictures that were taken by something else, and what their names tell.
struct PictureFolder {
  std::filesystem::path folder;
  std::string camera_from_name;  ///< NamePattern; empty: one camera, "camera"
  std::string stop_from_name;    ///< NamePattern; empty: no stops, each picture has a pose of its own
  std::string angles_deg;        ///< see StopAngles; empty: unknown
  Subject subject = Subject::kObject;
  bool linear = false;
};

/// Copies all pictures of a folder (not of its sub-folders; files with other extensions than those of pictures are left
/// out) into a new, closed recording, byte for byte and with their names. The recording appears whole or not at all: it
/// is made in a hidden folder beside `out` and renamed. Errors: kNotFound, kIo, kDiskFull, kCancelled; kBadInput (`out`
/// is there and not empty, a picture cannot be decoded, one camera's pictures differ in size, the names do not fit).
Result<Recording> ImportRecording(const PictureFolder& pictures, const std::filesystem::path& out,
                                  const Execution& execution);

}  // namespace rigcal
