#include "config/mask_files.h"

#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <regex>

namespace rigcal {
namespace {

/// The regular files of a folder by their stem, in the order of their names.
using FilesByStem = std::map<std::string, std::vector<std::filesystem::path>>;

Result<FilesByStem> ListByStem(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> paths;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::error_code ignored; entry->is_regular_file(ignored)) paths.push_back(entry->path());
  if (error)
    return Fail(ErrorCode::kNotFound, "{}: the folder of masks cannot be read ({})", folder.string(), error.message());
  std::sort(paths.begin(), paths.end());
  FilesByStem files;
  for (const std::filesystem::path& path : paths) files[path.stem().string()].push_back(path);
  return files;
}

/// How a mask's stem follows from its image's.
class StemRule {
 public:
  static Result<StemRule> Parse(const std::string& pattern) {
    StemRule rule;
    rule.pattern_ = pattern;
    if (pattern.empty()) return rule;
    const std::size_t equals = pattern.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == pattern.size())
      return Fail(ErrorCode::kBadInput, "mask from name: '{}' is not of the form REGEX=REPLACEMENT", pattern);
    try {
      rule.regex_ = std::regex(pattern.substr(0, equals));
    } catch (const std::regex_error& error) {
      return Fail(ErrorCode::kBadInput, "mask from name: '{}' is not a regular expression ({})",
                  pattern.substr(0, equals), error.what());
    }
    rule.replacement_ = pattern.substr(equals + 1);
    return rule;
  }

  [[nodiscard]] Result<std::string> MaskStem(const std::string& image_stem) const {
    if (pattern_.empty()) return image_stem;
    std::smatch match;
    if (!std::regex_match(image_stem, match, regex_))
      return Fail(ErrorCode::kBadInput, "mask from name: '{}' does not match the image name '{}'", pattern_,
                  image_stem);
    return match.format(replacement_);
  }

 private:
  std::string pattern_, replacement_;
  std::regex regex_;
};

Result<std::filesystem::path> OneMask(const FilesByStem& files, const std::string& stem, const std::string& image_name,
                                      const std::filesystem::path& folder) {
  const auto found = files.find(stem);
  std::vector<std::filesystem::path> candidates;
  if (found != files.end()) candidates = found->second;
  if (candidates.size() > 1)  // a note or a side-car file beside the mask is no second mask
    std::erase_if(candidates, [](const auto& path) { return !cv::haveImageReader(path.string()); });
  if (candidates.empty())
    return Fail(ErrorCode::kNotFound, "{}: holds no mask '{}.*' for the image '{}'", folder.string(), stem, image_name);
  if (candidates.size() > 1)
    return Fail(ErrorCode::kBadInput, "{}: more than one mask for the image '{}': {} and {}", folder.string(),
                image_name, candidates[0].filename().string(), candidates[1].filename().string());
  return candidates[0];
}

}  // namespace

Result<std::vector<std::filesystem::path>> FindMaskFiles(const std::vector<std::string>& image_names,
                                                         const std::filesystem::path& folder,
                                                         const std::string& mask_from_name) {
  const Result<StemRule> rule = StemRule::Parse(mask_from_name);
  if (!rule) return Fail(rule.error());
  std::map<std::filesystem::path, FilesByStem> listings;
  std::vector<std::filesystem::path> masks;
  for (const std::string& name : image_names) {
    const std::filesystem::path mask_folder = folder / std::filesystem::path(name).parent_path();
    if (!listings.contains(mask_folder)) {
      Result<FilesByStem> listing = ListByStem(mask_folder);
      if (!listing) return Fail(listing.error());
      listings[mask_folder] = *std::move(listing);
    }
    const Result<std::string> stem = rule->MaskStem(std::filesystem::path(name).stem().string());
    if (!stem) return Fail(stem.error());
    const auto mask = OneMask(listings[mask_folder], *stem, name, mask_folder);
    if (!mask) return Fail(mask.error());
    masks.push_back(*mask);
  }
  return masks;
}

}  // namespace rigcal
