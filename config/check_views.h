#pragma once

#include "core/base/result.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

/// Whether the views can have seen one object together. Refused are: all cameras in one place; cameras that have the
/// point where the optical axes meet behind them; views whose picture shares no volume with any other one. Judged by
/// the pinhole cameras alone, whose image sizes must be known. Errors: kBadInput naming the views.
Result<void> CheckViewsMeet(const RigCalibration& calibration);

}  // namespace rigcal
