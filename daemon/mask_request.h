#pragma once

#include <filesystem>
#include <string>

#include "config/load_images.h"
#include "core/base/result.h"

namespace rigcal {

/// --masks DIR|auto|none and --mask-from-name PATTERN, as given.
struct MaskRequest {
  std::string source = "auto";
  std::string mask_from_name;

  [[nodiscard]] MaskSource Source() const;
  /// Errors: kBadInput: a pattern for names of masks without a folder of them.
  [[nodiscard]] Result<void> Check() const;
  /// The folder of masks; empty for auto and none.
  [[nodiscard]] std::filesystem::path Folder() const;
};

}  // namespace rigcal
