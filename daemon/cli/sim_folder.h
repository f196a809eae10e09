#pragma once

#include <filesystem>
#include <vector>

#include "core/base/execution.h"
#include "sim_fixtures/disturb.h"
#include "sim_fixtures/truth_file.h"

namespace rigcal {

struct SimFolderOptions {
  sim::ShotOptions shot;
  std::vector<double> disturb_px = {6, 12};  ///< mean errors of the disturbed starts
  int num_points = 3000;
  bool recording = false;  ///< also recording.json and rig.toml
};

/// Renders every view of the studio into a folder (made when it is not there), each file whole or not at all:
///   <view>.png, masks/<view>.png (255: object, and table top where there is one), truth_par.txt (Middlebury),
///   truth.json (all that is needed to make the same studio again, and the cameras), points.txt (x y z k v1 .. vk),
///   start_<E>px_par.txt (disturbed cameras).
/// With distortion the *_par.txt hold the cameras of the undistorted pictures, and truth_calibration.json and
/// start_<E>px_calibration.json those of the pictures. Pictures of a chart held by hand come with the views and are
/// told by truth.json alone. A folder with a recording is not written over. Errors: kBadInput, kIo, kDiskFull,
/// kCancelled.
Result<void> WriteSimFolder(const sim::Studio& studio, const SimFolderOptions& options,
                            const std::filesystem::path& folder, const Execution& execution);

/// One more disturbed start of a folder that WriteSimFolder wrote.
Result<void> WriteSimStart(const sim::Studio& studio, const std::vector<sim::VisiblePoint>& points,
                           const sim::DisturbOptions& options, const std::filesystem::path& stem);

}  // namespace rigcal
