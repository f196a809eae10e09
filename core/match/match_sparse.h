#pragma once

#include <cstdint>
#include <vector>

#include "core/base/execution.h"
#include "core/scene/image_set.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

struct SparseMatchOptions {
  std::vector<double> expected_error_px;  ///< Er per view: how far from the epipolar line a match may lie
  int max_features_per_view = 3000;
  std::uint64_t random_seed = 1;
};

/// Plain feature tracks (SIFT, searched along the rough epipolar lines): they join the patches while the cameras are
/// still far off (DESIGN.md section 3, point 7). Errors: kCancelled.
Result<TrackSet> MatchSparse(const ImageSet& images, const RigCalibration& calibration,
                             const SparseMatchOptions& options, const Execution& execution);

/// Er from the pictures: how many full-size pixels the cameras are off, conservatively, per view and as one number,
/// from sparse matches that no camera has gated (paper section 3.1: "conservative estimate").
struct ExpectedErrorEstimate {
  double overall_px = 0;            ///< that of all views, or of one that stands out
  std::vector<double> per_view_px;  ///< at least kAssumedErrorPx where a view has too few matches to tell
  int num_matches = 0;              ///< observations that agree with each other, whatever the cameras say
  /// Too few matches to tell: all errors are kAssumedErrorPx.
  bool assumed = false;
};

/// Taken for Er where the pictures do not tell: level 3, which still finds cameras that are off by twice as much.
inline constexpr double kAssumedErrorPx = 8.0;

/// Sees only what makes the views disagree: an error that all cameras share, such as a common scale, stays hidden.
/// Errors: kCancelled.
Result<ExpectedErrorEstimate> EstimateExpectedError(const ImageSet& images, const RigCalibration& calibration,
                                                    const Execution& execution);

}  // namespace rigcal
