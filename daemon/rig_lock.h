#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "core/base/descriptor.h"
#include "core/base/result.h"

namespace rigcal {

/// What stands in the lock of a rig, for others to read.
struct RigHolder {
  std::string what;         ///< "rigcal capture --out night7"
  std::string ask_instead;  ///< the command that asks the holder for the same; empty: there is none
};

/// Holds a rig: one program at a time, as long as this lives. The kernel lets go when the program ends, however it
/// does.
class RigLock {
 public:
  /// Takes the lock of a rig, by its rig file, in a folder that all programs of the machine share; the folder is made
  /// unless it is there. Errors: kDevice when somebody holds it, saying who and what to do; kIo.
  static Result<RigLock> Take(const std::filesystem::path& run_folder, const std::filesystem::path& rig_file,
                              const RigHolder& holder);

 private:
  explicit RigLock(Descriptor file) : file_(std::move(file)) {}
  Descriptor file_;  ///< locked; closing it lets go
};

/// Where locks are: $RIGCAL_RUN_DIR, else /run/rigcal where it may be written, else a folder of the user's below the
/// temporary one.
std::filesystem::path DefaultRunFolder();

}  // namespace rigcal
