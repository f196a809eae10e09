#pragma once

#include <string>

#include "core/base/result.h"
#include "drivers/driver.h"

namespace rigcal {

/// A recording, closed or not, as the replay driver wants it. Errors: those of LoadRecording.
Result<RecordedPictures> OpenRecordedPictures(const std::string& folder);

}  // namespace rigcal
