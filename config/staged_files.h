#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/publish_files.h"
#include "core/base/descriptor.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// The name below the publish folder of a format's file or folder; `format` itself where it is none.
std::string PublishedName(const std::string& format);

/// A locked publish folder and a hidden folder in it, where the formats are written before they get their names.
/// Removes at its end what did not get one.
class StagedFiles {
 public:
  explicit StagedFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;
  ~StagedFiles();

  /// Makes the folder and locks it. Errors: those of PrepareOutputFolder, kTimeout, kCancelled, kIo.
  Result<void> Lock(Clock& clock, const std::stop_token& stop);

  /// Writes every format, hidden. Returns what the exports note. Errors: those of Export; kBadInput: an unknown format,
  /// one that is asked for twice, or something in its place that is not of an earlier publication.
  Result<std::vector<std::string>> Write(const RigCalibration& calibration,
                                         const std::vector<PublishedFormat>& formats);

  /// Gives the written formats their names, a file by renaming it and a folder by renaming a symbolic link to it, then
  /// writes current.json. Removes what the current.json of before had in other formats, which would grow old, and
  /// hidden folders that nothing links to any more but the last one, which somebody may still be reading. Errors: kIo,
  /// kDiskFull.
  Result<void> Show(const std::string& current_text);

 private:
  /// Errors: kBadInput: what has the name now would not give way to it.
  Result<void> CheckPlace(const std::string& name, bool is_folder) const;
  Result<void> ShowFolder(const std::string& name);
  void RemoveOldFolders() const;

  std::filesystem::path folder_, staged_;
  std::vector<std::string> names_;
  std::string shown_before_;  ///< hidden folder that the links led to
  bool linked_ = false;       ///< a link leads to staged_
  Descriptor lock_;           ///< of the folder
};

}  // namespace rigcal
