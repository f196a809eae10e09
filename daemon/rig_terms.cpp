#include "daemon/rig_terms.h"

#include "core/rig/rig_prior.h"

namespace rigcal {
namespace {

/// How far a mount may have crept since the chart was seen: a tenth of a pixel at 2000 px of focal length and 0.5 m.
/// Chosen.
constexpr double kMountDriftRad = 5e-5, kMountDriftM = 2.5e-5;
/// And its lens, by temperature: 0.2 px at the edge of a picture of 4000 px. Chosen.
constexpr double kFocalDriftShare = 1e-4, kCentreDriftPx = 0.1;

}  // namespace

RigTerms RigTermsOf(const RigViews& placed) {
  const RigEstimate& rig = *placed.calibration.rig;
  const std::size_t num_stops = placed.stops.size();
  return {.prior = {placed.calibration.cameras, rig.model, rig.covariance},
          .start = {rig.model, std::vector(num_stops, StopError(StopError::Zero()))},
          .stops = placed.stops,
          .stop_error_sigma = std::vector(num_stops, rig.model.error_sigma),
          .stop_of_view = placed.stop_of_view,
          .axes = rig.axes};
}

void AllowForCreep(RigTerms& terms) {
  for (int c = 0; c < static_cast<int>(terms.prior.cameras.size()); ++c) {
    if (terms.prior.model.cam_from_mount[c]) LoosenMount(c, kMountDriftRad, kMountDriftM, terms.prior);
    LoosenLens(c, kFocalDriftShare, kCentreDriftPx, terms.prior);
  }
}

}  // namespace rigcal
