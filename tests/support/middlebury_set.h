#pragma once

#include <filesystem>
#include <optional>

#include "core/scene/image_set.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

struct TestSet {
  ImageSet images;
  RigCalibration calibration;
};

/// A folder of photographs with a Middlebury par file, as tests and benchmarks read them: grey, no distortion, one
/// camera for each view, masks from the folder `masks` beside the images when `with_masks`. Nothing when a file is not
/// there or cannot be read.
std::optional<TestSet> LoadTestSet(const std::filesystem::path& folder, const std::filesystem::path& par,
                                   int num_levels, bool with_masks = false);

/// The folder of recorded sets (environment variable RIGCAL_DATA); nothing when it is not set.
std::optional<std::filesystem::path> RecordedSets();

}  // namespace rigcal
