#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sim_fixtures/image_folder.h"

namespace rigcal::sim {

/// Writes a file under another name and renames it: there is the whole file or none. Errors: kIo, kDiskFull.
Result<void> WriteWhole(const std::filesystem::path& file, std::string_view bytes);

/// Middlebury's *_par.txt with 17 significant digits.
std::string MiddleburyText(const RigCalibration& calibration);
/// `x y z k v1 .. vk` lines.
std::string PointsText(const std::vector<VisiblePoint>& points);

nlohmann::ordered_json TruthJson(const Studio& studio, const FolderOptions& options);
/// Options of the studio from truth.json; errors name the key.
Result<StudioOptions> StudioOptionsFromJson(const nlohmann::json& truth);

}  // namespace rigcal::sim
