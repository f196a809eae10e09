#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace rigcal {

/// The mask of each image in a folder: the file with the same stem, any extension. With `mask_from_name`,
/// "REGEX=REPLACEMENT", the stem is found by replacing the image's whole stem: 'image_0*([0-9]+)=contour_$1' finds
/// contour_7.png for image_07.jpg. Images in a sub-folder have their masks in the same sub-folder of `folder`. Errors:
/// kNotFound (no mask for an image), kBadInput (more than one, or a bad pattern).
Result<std::vector<std::filesystem::path>> FindMaskFiles(const std::vector<std::string>& image_names,
                                                         const std::filesystem::path& folder,
                                                         const std::string& mask_from_name);

}  // namespace rigcal
