#include "core/drift/rig_evidence.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/base/ensure.h"
#include "core/rig/camera_information.h"
#include "core/rig/rig_prior.h"

namespace rigcal {
namespace {

/// root * root^T = covariance, for one that may be singular; rows have different units and are scaled first.
Eigen::MatrixXd RootOf(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd scale = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(correlation);
  const Eigen::VectorXd widths = spectrum.eigenvalues().cwiseMax(0).cwiseSqrt();
  return sigma.asDiagonal() * spectrum.eigenvectors() * widths.asDiagonal();
}

}  // namespace

RigEvidence EvidenceOf(const DriftInput& input) {
  Ensure(input.found.rig.has_value(), "what was found has a rig with its covariance");
  RigPrior released = input.in_force;
  for (int c = 0; c < static_cast<int>(released.cameras.size()); ++c) {
    if (released.model.cam_from_mount[c]) LoosenMount(c, input.released_rad, input.released_m, released);
  }
  RigEvidence evidence{.rows = released.FreeRows()};
  const std::vector<int>& rows = evidence.rows;
  const Eigen::MatrixXd known = released.covariance.joint(rows, rows);
  const Eigen::MatrixXd found = input.found.rig->covariance.joint(rows, rows);
  const Eigen::MatrixXd after = CovarianceFromInformation(found);
  const Eigen::VectorXd departure = DepartureFrom(input.in_force, input.found.cameras, input.found.rig->model)(rows);
  evidence.information = after - CovarianceFromInformation(known);
  evidence.pull = after * departure;
  evidence.stated_root = RootOf(input.in_force.covariance.joint(rows, rows));
  return evidence;
}

Explanation Explain(const RigEvidence& evidence, const std::vector<Mover>& movers) {
  const Eigen::Index num_rows = evidence.stated_root.rows();
  const auto num_motions = static_cast<Eigen::Index>(movers.size()) * kMotionSize;
  // Unknowns of unit variance: the errors of the calibration in force, then the motions.
  Eigen::MatrixXd root(num_rows, num_rows + num_motions);
  root.leftCols(num_rows) = evidence.stated_root;
  for (std::size_t m = 0; m < movers.size(); ++m) {
    root.middleCols(num_rows + static_cast<Eigen::Index>(m) * kMotionSize, kMotionSize) =
        movers[m].by_motion * movers[m].width.asDiagonal();
  }
  const Eigen::MatrixXd information = root.transpose() * evidence.information * root;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(0.5 * (information + information.transpose()));
  // A difference of two inverses may round to a little below nothing.
  const Eigen::VectorXd precision = spectrum.eigenvalues().cwiseMax(0).array() + 1;
  const Eigen::MatrixXd& axes = spectrum.eigenvectors();
  const Eigen::VectorXd along = axes.transpose() * (root.transpose() * evidence.pull);
  const Eigen::VectorXd mean = axes * along.cwiseQuotient(precision);

  Explanation out{.fit = along.dot(along.cwiseQuotient(precision))};
  out.log_evidence = out.fit - precision.array().log().sum();
  for (std::size_t m = 0; m < movers.size(); ++m) {
    const Eigen::Index first = num_rows + static_cast<Eigen::Index>(m) * kMotionSize;
    const MotionVector& width = movers[m].width;
    const Eigen::MatrixXd own = axes.middleRows(first, kMotionSize);
    out.motion.emplace_back(width.cwiseProduct(mean.segment<kMotionSize>(first)));
    const MotionMatrix covariance = own * precision.cwiseInverse().asDiagonal() * own.transpose();
    out.covariance.emplace_back(width.asDiagonal() * covariance * width.asDiagonal());
  }
  return out;
}

}  // namespace rigcal
