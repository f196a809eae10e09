#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "config/run_report.h"
#include "core/adjust/adjust.h"
#include "core/base/result.h"
#include "core/rig/priors.h"
#include "core/scene/image_set.h"
#include "core/scene/patch.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"
#include "daemon/run_context.h"

namespace rigcal {

/// kPaper: the recipe exactly as printed, for comparison (DESIGN.md section 3). kRigcal: the one that has to work.
enum class RefineMethod { kRigcal, kPaper };

struct RefineOptions {
  RefineMethod method = RefineMethod::kRigcal;
  std::optional<double> expected_error_px;  ///< Er; estimated from the pictures when absent
  int num_rounds = 4;                       ///< paper section 3.2
  IntrinsicsMode intrinsics = IntrinsicsMode::kPerCamera;
  std::vector<CameraPrior> camera_priors;  ///< one per camera
  std::vector<bool> fixed_views;           ///< --fix-cameras; empty: none
  std::optional<RigTerms> rig;             ///< --poses rig: the poses are those of a rig; nothing: they are free
  double holdout_share = 0.12;             ///< of the tracks (DESIGN.md section 4: 10 to 20 %)
  std::uint64_t random_seed = 1;
};

/// What a run leaves behind. The report names the verdict; everything is there whatever the verdict is.
struct RefinedRig {
  RigCalibration calibration;
  std::vector<Patch> patches;                ///< of the last round
  std::vector<cv::Vec3b> patch_colours_bgr;  ///< one for each patch
  TrackSet tracks;                           ///< of the last round, held-out ones marked
  std::vector<std::string> slips;            ///< of report.contradictions, those that say where the positioner slipped
  RunReport report;
};

/// The main job: [stereo -> match -> adjust] x rounds -> validate (DESIGN.md section 2). `seed` holds the cameras as
/// they came; with kPaper and with IntrinsicsMode::kPerView it has one camera per view. Errors: kCancelled; kBadInput
/// when the pictures cannot carry a run at all.
Result<RefinedRig> RefineRig(const ImageSet& images, const RigCalibration& seed, const RefineOptions& options,
                             RunContext& context);

/// The verdict alone, on cameras from anywhere: stereo and matching with the cameras as they are, then validation
/// against `prior` when there is one. The result's calibration is the input.
Result<RefinedRig> ValidateRig(const ImageSet& images, const RigCalibration& cameras,
                               const std::optional<RigCalibration>& prior, const RefineOptions& options,
                               RunContext& context);

}  // namespace rigcal
