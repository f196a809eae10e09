#pragma once

#include <cstdint>
#include <vector>

#include "core/base/execution.h"
#include "core/scene/image_set.h"
#include "core/scene/patch.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

namespace rigcal {

struct MatchOptions {
  int level = 2;         ///< L, where the refinement of a feature starts (paper section 3.2)
  int window_px = 7;     ///< delta: side of the largest projection of the 3-D patch Q, pixels of the level at work
  double min_ncc = 0.7;  ///< features below are dropped (DESIGN.md section 3, point 4); 0 for --method paper
  std::vector<double> expected_error_px;  ///< Er per view: a feature that moved farther is dropped
  int blocks_per_side = 10;  ///< of each image, over which sub-sampling spreads what it keeps (paper section 3.1)
  double kept_share = 1;     ///< share of the tracks that sub-sampling aims at (paper: 10 to 20 %); 1 keeps all
  /// With more features than this fewer tracks are kept: each costs the adjustment 1.1 kB (measured on 36 views of 12
  /// megapixels, 2.2 million of them), and a view's features are worth no more than one of systematic_sigma_px
  /// together.
  int max_features = 700'000;
  int min_features_per_view = 100;  ///< sub-sampling never goes below (DESIGN.md section 3, point 3)
  /// No feature is believed to be better than this, whatever its own fit says: what differs between the pictures but
  /// is not noise (shape of the patch, shading) has this size on rendered textures (0.02 to 0.04 px).
  double min_sigma_px = 0.02;
  std::uint64_t random_seed = 1;
};

/// Multi-view feature matching (paper section 3.2): from patches to tracks with sub-pixel features at full size.
/// Errors: kCancelled. Tracks with fewer than two features are left out.
Result<TrackSet> Match(const ImageSet& images, const RigCalibration& calibration, const std::vector<Patch>& patches,
                       const MatchOptions& options, const Execution& execution);

}  // namespace rigcal
