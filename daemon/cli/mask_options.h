#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "config/load_images.h"

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

/// Declares both options on a subcommand; `request` must live until it is parsed.
void AddMaskOptions(CLI::App& command, MaskRequest& request);

}  // namespace rigcal
