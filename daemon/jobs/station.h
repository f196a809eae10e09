#pragma once

#include <filesystem>
#include <string>

#include "config/publish_files.h"
#include "config/rig_file.h"
#include "core/base/result.h"

namespace rigcal {

/// The rig that a service looks after, and where it keeps what. Made anew when the rig file is read again.
struct Station {
  std::string name;                ///< of the rig in the store
  std::filesystem::path rig_file;  ///< absolute
  std::string rig_text;            ///< of the file, as it was read
  RigFile rig;
  std::filesystem::path state;  ///< folder, absolute
  PublishFolder publish;
  int num_threads = 1;

  [[nodiscard]] std::filesystem::path StoreFile() const;
  [[nodiscard]] std::filesystem::path Recordings() const { return state / "recordings"; }
  /// What a job writes beside recordings and revisions: what it began with, and its results.
  [[nodiscard]] std::filesystem::path JobFolder(int job) const;
};

/// Errors: those of ReadFile and ParseRig.
Result<Station> LoadStation(const std::filesystem::path& rig_file, const std::filesystem::path& state, int num_threads);

}  // namespace rigcal
