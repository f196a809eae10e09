#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "config/read_file.h"
#include "core/base/execution.h"
#include "core/scene/image_set.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

enum class MaskSource { kAuto, kNone, kFolder };

struct ImageOptions {
  int num_levels = 1;     ///< of each pyramid; 1: the full-size picture alone
  int colour_level = -1;  ///< level at which colours are kept; below 0: no colours
  MaskSource masks = MaskSource::kAuto;
  std::filesystem::path mask_folder;                   ///< for kFolder
  std::string mask_from_name;                          ///< for kFolder, see FindMaskFiles
  std::map<std::string, std::string> sha256_by_image;  ///< of a recording: others are refused; empty: unknown
};

/// What a view's mask comes from.
enum class MaskKind { kNone, kFile, kDarkBackground, kStaticBackground };

/// "none", "file", "dark" or "static": as report.json has it.
const char* NameOf(MaskKind kind);

struct LoadedImages {
  ImageSet images;                   ///< same order as the calibration's views
  std::vector<double> object_share;  ///< per view, share of the picture that is object; 1 without a mask
  std::vector<MaskKind> mask_kind;   ///< per view
  std::vector<InputFile> files;      ///< images, then masks
};

/// Reads the picture of every view from `folder`, undistorts it and builds its pyramid, finds or reads the masks. Sizes
/// of cameras that are not known (0) are filled in. Checks that the cameras fit the pictures and can have seen one
/// object (CheckViewsMeet). Errors: kNotFound, kIo, kBadInput, kUnsupported, kCancelled.
Result<LoadedImages> LoadImages(const std::filesystem::path& folder, RigCalibration& calibration,
                                const ImageOptions& options, const Execution& execution);

}  // namespace rigcal
