#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/scene/recording.h"

namespace rigcal {

/// Name of the file that makes a folder a recording (docs/recording.md, docs/schema/recording.schema.json).
inline constexpr const char* kRecordingFile = "recording.json";

/// "chart", "object" or "both": as recording.json and --what have it.
const char* NameOf(Subject subject);

/// The text of a recording.json. The same recording gives the same bytes; numbers read back as the same double.
std::string RecordingText(const Recording& recording);

/// Reads the text of a recording.json; `file` names it in messages. Keys that are not in the schema are refused: a
/// value in another unit must not pass unseen. Errors: kBadInput (naming key and value), kUnsupported (newer version).
Result<Recording> ParseRecording(std::string_view text, const std::string& file);

/// The recording in a folder, closed or not; its pictures are not looked at. Errors: kNotFound, kIo, and those of
/// ParseRecording.
Result<Recording> LoadRecording(const std::filesystem::path& folder);

/// Whether a recording can be one: ids, serials and files are there once, indices exist, files lie inside the folder,
/// sizes and numbers have values that can be, a camera has one picture of a subject at a stop. Errors: kBadInput.
Result<void> CheckConsistent(const Recording& recording);

}  // namespace rigcal
