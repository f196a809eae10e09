#pragma once

#include <CLI/CLI.hpp>

#include "daemon/mask_request.h"
#include "daemon/picture_source.h"
#include "daemon/run_request.h"

namespace rigcal {

// What each fills must live until the command line is parsed.

/// --images, --recording, --camera-from-name.
void AddPictureOptions(CLI::App& command, PictureSource& source);

/// --masks, --mask-from-name.
void AddMaskOptions(CLI::App& command, MaskRequest& request);

/// Those and the others that `refine` and `validate` share.
void AddRunOptions(CLI::App& command, RunRequest& request);

}  // namespace rigcal
