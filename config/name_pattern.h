#pragma once

#include <regex>
#include <string>

#include "core/base/result.h"

namespace rigcal {

/// Longest name of an image: std::regex recurses once per character.
inline constexpr std::size_t kMaxImageNameLength = 1024;

/// What the name of an image tells (its camera, its stop): a regular expression that is searched in the name; its first
/// group is the answer.
class NamePattern {
 public:
  /// `what` ("camera") names the option, "camera from name", in messages. Errors: kBadInput.
  static Result<NamePattern> Parse(const std::string& pattern, const std::string& what);

  /// The first group, not empty. Errors: kBadInput naming the image.
  [[nodiscard]] Result<std::string> Find(const std::string& image_name) const;

 private:
  NamePattern(std::string pattern, std::string what, std::regex regex);

  std::string pattern_, what_;
  std::regex regex_;
};

}  // namespace rigcal
