#include "core/adjust/rig_posterior.h"

#include <algorithm>

#include "core/rig/camera_information.h"
#include "core/rig/poses_by_rig.h"

namespace rigcal {
namespace {

/// Inverse of what is known before; its columns in `free`, the others are held.
Eigen::MatrixXd PriorInformation(const RigTerms& rig, const RigColumns& columns, std::vector<int>& free) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns.Count(), columns.Count());
  free = rig.prior.FreeRows();
  information(free, free) = CovarianceFromInformation(rig.prior.covariance.joint(free, free));
  for (int s = 0; s < columns.num_stops; ++s) {
    for (int k = 0; k < kStopErrorSize; ++k) {
      const double sigma = rig.stop_error_sigma[s][k];
      if (sigma == 0) continue;
      free.push_back(columns.Stop(s) + k);
      information(free.back(), free.back()) = 1 / (sigma * sigma);
    }
  }
  return information;
}

}  // namespace

void WriteRigPosterior(const Eigen::MatrixXd& features, const BundleTerms& terms, Adjustment& out) {
  const RigTerms& rig = *terms.rig;
  const RigState& state = out.rig->state;
  const RigColumns columns{out.calibration.NumCameras(), static_cast<int>(rig.stops.size())};
  const Eigen::MatrixXd by_rig =
      PosesByRig(state.model, rig.stops, state.stop_errors, rig.stop_of_view, out.calibration);
  std::vector<int> free;
  Eigen::MatrixXd information = PriorInformation(rig, columns, free);
  const Eigen::MatrixXd used = by_rig(terms.free.JointRows(), Eigen::all);
  information += used.transpose() * features * used;
  // Intrinsics that are held by the run are known to it: their columns leave the information.
  const std::vector<int> estimated = terms.free.JointRows();
  const std::size_t num_free = free.size();
  std::erase_if(free, [&](int column) {
    const bool intrinsic = column < RigCovariance::MountRow(columns.num_cameras, 0);
    return intrinsic && std::find(estimated.begin(), estimated.end(), column) == estimated.end();
  });
  const bool lens_is_held = free.size() != num_free;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(columns.Count(), columns.Count());
  covariance(free, free) = CovarianceFromInformation(information(free, free));

  out.calibration.covariance = CalibrationCovariance{by_rig * covariance * by_rig.transpose()};
  const int size = RigCovariance::Size(columns.num_cameras);
  out.calibration.rig = RigEstimate{state.model, {}, {covariance.topLeftCorner(size, size)}};
  // A lens that the run was told to hold is not known any better: later runs start from what was known before.
  if (lens_is_held) out.calibration.rig->covariance = rig.prior.covariance;
  for (int s = 0; s < columns.num_stops; ++s) {
    out.rig->stop_error_sigma[s] =
        covariance.diagonal().segment<kStopErrorSize>(columns.Stop(s)).cwiseMax(0).cwiseSqrt();
  }
}

}  // namespace rigcal
