#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/scene/image_set.h"
#include "core/scene/patch.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// One vertex of patches.ply: single precision, as the file has it.
struct PatchVertex {
  Eigen::Vector3f centre_in_world;
  Eigen::Vector3f normal_in_world;
  std::uint8_t red = 0, green = 0, blue = 0;
  std::uint8_t num_views = 0;  ///< that see the patch; 255: at least so many
  float ncc = 0;
};

/// Colour (BGR) of each patch's centre in its reference view; grey where the images keep no colours.
std::vector<cv::Vec3b> PatchColours(const std::vector<Patch>& patches, const ImageSet& images,
                                    const RigCalibration& calibration);

/// The bytes of patches.ply: binary little-endian, x y z nx ny nz (float) red green blue views (uchar) ncc (float).
/// `colours_bgr` has one entry for each patch.
std::string PatchesPly(const std::vector<Patch>& patches, const std::vector<cv::Vec3b>& colours_bgr);

/// Writes PatchesPly atomically. Errors: kIo, kDiskFull.
Result<void> WritePatches(const std::filesystem::path& path, const std::vector<Patch>& patches,
                          const std::vector<cv::Vec3b>& colours_bgr);

/// The vertices of a file with exactly the properties that PatchesPly writes. Errors: kBadInput.
Result<std::vector<PatchVertex>> ParsePatches(std::string_view bytes, const std::string& file);

}  // namespace rigcal
