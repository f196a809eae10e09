#pragma once

#include <span>
#include <vector>

#include "core/base/execution.h"
#include "core/rig/priors.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

/// Cameras near the given ones with what every real camera has: one set of intrinsics for each physical camera, no
/// skew, an aspect near its prior; as the features ask for. The given cameras enter as a weak prior in the picture, so
/// that directions which features do not determine stay where they are. Good cameras hardly move; cameras bent by a
/// projectivity move back as far as the features tell, whether the bending sits in the intrinsics (a projectivity
/// leaves no residual, but no single set of intrinsics either) or was forced into residuals. `camera_priors`: one per
/// camera of `judged`. Errors: kCancelled.
Result<RigCalibration> RefitAsMetric(const RigCalibration& judged, const std::vector<Track>& tracks,
                                     std::span<const CameraPrior> camera_priors, const Execution& execution);

}  // namespace rigcal
