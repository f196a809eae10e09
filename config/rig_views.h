#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/read_file.h"
#include "core/base/result.h"
#include "core/scene/recording.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// A calibration.json whose cameras belong to a rig.
struct RiggedCameras {
  RigCalibration calibration;
  InputFile file;
};

/// Nothing when the file is another camera file or says nothing of a rig. Errors: those of ReadFile and
/// ParseCalibration.
Result<std::optional<RiggedCameras>> LoadRiggedCameras(const std::filesystem::path& path);

/// The object's views of a recording at the stops of a rig.
struct RigViews {
  RigCalibration calibration;  ///< cameras, unit and rig as they were; the recording's views
  std::vector<StopPosition> stops;
  std::vector<int> stop_of_view;
};

/// Gives every picture of the object the pose that the rig gives it at its stop, had that no error. `cameras` and
/// `recording_name` name the sources in messages. Errors: those of StopPositions; kBadInput: a camera that the
/// calibration does not have, that cannot be one (CheckIntrinsics), that is of another size or has no place in the rig,
/// a picture without a stop, fewer than three views.
Result<RigViews> PlaceRecording(const RigCalibration& rigged, const std::string& cameras, const Recording& recording,
                                const std::string& recording_name);

}  // namespace rigcal
