#include "config/name_pattern.h"

namespace rigcal {

NamePattern::NamePattern(std::string pattern, std::string what, std::regex regex)
    : pattern_(std::move(pattern)), what_(std::move(what)), regex_(std::move(regex)) {}

Result<NamePattern> NamePattern::Parse(const std::string& pattern, const std::string& what) {
  try {
    std::regex regex(pattern);
    if (regex.mark_count() < 1)
      return Fail(ErrorCode::kBadInput, "{} from name: '{}' has no group (...) that could name the {}", what, pattern,
                  what);
    return NamePattern(pattern, what, std::move(regex));
  } catch (const std::regex_error& error) {
    return Fail(ErrorCode::kBadInput, "{} from name: '{}' is not a regular expression ({})", what, pattern,
                error.what());
  }
}

Result<std::string> NamePattern::Find(const std::string& image_name) const {
  if (image_name.size() > kMaxImageNameLength)
    return Fail(ErrorCode::kBadInput, "{} from name: an image name has {} characters, at most {} are allowed", what_,
                image_name.size(), kMaxImageNameLength);
  try {
    std::smatch match;
    if (std::regex_search(image_name, match, regex_) && match.length(1) > 0) return match.str(1);
  } catch (const std::regex_error& error) {
    return Fail(ErrorCode::kBadInput, "{} from name: '{}' cannot be searched in '{}' ({})", what_, pattern_, image_name,
                error.what());
  }
  return Fail(ErrorCode::kBadInput, "{} from name: '{}' finds no {} in the image name '{}'", what_, pattern_, what_,
              image_name);
}

}  // namespace rigcal
