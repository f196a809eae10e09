#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/execution.h"
#include "core/scene/recording.h"

namespace rigcal {

/// What is to be said about a recording, one sentence each, in a fixed order.
struct RecordingFindings {
  Recording recording;
  std::vector<std::string> faults;   ///< it is not whole: not closed, a file missing, changed or of the wrong size
  std::vector<std::string> remarks;  ///< foreign files, over-exposed pictures, stops and cameras without a view
};

/// Files and links below the folder that the recording does not list, sorted; temporary files of an interrupted write
/// (config/atomic_file.h) among them.
std::vector<std::string> ForeignFiles(const std::filesystem::path& folder, const Recording& recording);

/// Looks at every picture and every file of a recording. Errors: those of LoadRecording; kCancelled.
Result<RecordingFindings> CheckRecording(const std::filesystem::path& folder, const Execution& execution);

}  // namespace rigcal
