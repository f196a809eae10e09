#include "config/formats/view_file_names.h"

#include <filesystem>
#include <map>

namespace rigcal {

Result<std::vector<std::string>> ViewFileNames(const RigCalibration& calibration, const std::string& extension) {
  std::vector<std::string> names;
  std::map<std::string, std::string> image_of;
  for (const View& view : calibration.views) {
    names.push_back(std::filesystem::path(view.name).replace_extension(extension).string());
    const auto [other, is_new] = image_of.emplace(names.back(), view.name);
    if (!is_new)
      return Fail(ErrorCode::kUnsupported, "the images '{}' and '{}' would both have the file '{}'", other->second,
                  view.name, names.back());
  }
  return names;
}

}  // namespace rigcal
