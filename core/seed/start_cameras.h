#pragma once

#include "core/base/execution.h"
#include "core/seed/chart_state.h"
#include "core/seed/seed_cameras.h"

namespace rigcal {

/// Starting values from the flat board: every camera's intrinsics (k3 = 0) by OpenCV's closed form and least squares
/// over a spread of its views, then cam_from_board of every view that sees enough. `views` loses the corners of views
/// that no pose fits. Errors: kBadInput for a camera with too few views.
Result<ChartState> StartCameras(const SeedScene& scene, const SeedOptions& options, const Execution& execution,
                                std::vector<ChartView>& views);

}  // namespace rigcal
