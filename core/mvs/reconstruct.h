#pragma once

#include <vector>

#include "core/base/execution.h"
#include "core/scene/image_set.h"
#include "core/scene/patch.h"
#include "core/scene/rig_calibration.h"

namespace rigcal {

inline constexpr int kMaxStereoWindowPx = 15;  ///< largest correlation window

struct StereoOptions {
  int level = 2;         ///< pyramid level L that is reconstructed
  int cell_px = 2;       ///< zeta: one patch per cell of zeta x zeta pixels of the level (paper section 4.2: 2 or 4)
  int window_px = 7;     ///< gamma: side of the correlation window in pixels of the level (paper section 4.2: 7 or 9)
  int min_views = 3;     ///< least number of views of a patch
  double min_ncc = 0.7;  ///< least mean NCC of a patch (threshold of the PMVS paper)
  /// How far (pixels of the full-size image, per view) the cameras may be off on average: how wide epipolar searches
  /// are, and whether a view's texture may lie beside the projection of its patch. Empty: the cameras are exact.
  std::vector<double> expected_error_px;
};

/// Multi-view stereo: oriented patches on the surface (Furukawa & Ponce, CVPR 2007: match, expand, filter).
/// `images` and `calibration` have the same views in the same order; the pictures are undistorted, so only the pinhole
/// part of the cameras is used. The patches' order and values do not depend on execution.num_threads. Errors:
/// kCancelled.
Result<std::vector<Patch>> Reconstruct(const ImageSet& images, const RigCalibration& calibration,
                                       const StereoOptions& options, const Execution& execution);

}  // namespace rigcal
