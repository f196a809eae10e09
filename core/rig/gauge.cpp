#include "core/rig/gauge.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/rig/reprojection.h"

namespace rigcal {
namespace {

/// d (Disturbed() of one pose) / d (world turned, shifted, grown).
Eigen::Matrix<double, 6, 7> PoseByGauge(const Rigid3d& cam_from_world) {
  const Eigen::Matrix3d r = cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = cam_from_world.translation;
  Eigen::Matrix<double, 6, 7> d = Eigen::Matrix<double, 6, 7>::Zero();
  d.topLeftCorner<3, 3>() = -r;
  d.bottomLeftCorner<3, 3>() = -Skew(t) * r;
  d.block<3, 3>(3, 3) = -r;
  d.block<3, 1>(3, 6) = t;
  return d;
}

Rigid3d PoseInFrame(const Rigid3d& cam_from_old, const Similarity3d& new_from_old) {
  Rigid3d scaled = cam_from_old;
  scaled.translation *= new_from_old.scale;
  return scaled * new_from_old.b_from_a.Inverse();
}

}  // namespace

Eigen::Vector3d operator*(const Similarity3d& b_from_a, const Eigen::Vector3d& x_in_a) {
  return b_from_a.scale * (b_from_a.b_from_a.rotation * x_in_a) + b_from_a.b_from_a.translation;
}

RigCalibration InFrame(const RigCalibration& calibration, const Similarity3d& new_from_old_world) {
  RigCalibration moved = calibration;
  for (View& view : moved.views) view.cam_from_world = PoseInFrame(view.cam_from_world, new_from_old_world);
  if (moved.covariance) {
    // A disturbance (w, dt) of a camera's own frame becomes (w, scale dt).
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(moved.covariance->joint.rows());
    for (int view = 0; view < moved.NumViews(); ++view) {
      scale.segment<3>(CalibrationCovariance::PoseRow(moved.NumCameras(), view) + 3)
          .setConstant(new_from_old_world.scale);
    }
    moved.covariance->joint = scale.asDiagonal() * moved.covariance->joint * scale.asDiagonal();
  }
  return moved;
}

Eigen::Matrix<double, Eigen::Dynamic, 7> GaugeDirections(const RigCalibration& calibration) {
  Eigen::Matrix<double, Eigen::Dynamic, 7> directions(
      CalibrationCovariance::PoseRow(calibration.NumCameras(), calibration.NumViews()), 7);
  directions.setZero();
  for (int view = 0; view < calibration.NumViews(); ++view) {
    directions.middleRows<6>(CalibrationCovariance::PoseRow(calibration.NumCameras(), view)) =
        PoseByGauge(calibration.views[view].cam_from_world);
  }
  return directions;
}

Similarity3d AlignmentToSeed(const RigCalibration& calibration, std::span<const SeedAnchor> anchors) {
  constexpr int kMaxIterations = 20;
  constexpr double kConverged = 1e-12;  // relative step; far below any pixel
  Similarity3d total;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Eigen::Matrix<double, 7, 7> h = Eigen::Matrix<double, 7, 7>::Zero();
    Eigen::Matrix<double, 7, 1> g = Eigen::Matrix<double, 7, 1>::Zero();
    for (const SeedAnchor& anchor : anchors) {
      const View& view = calibration.views[anchor.view];
      const Rigid3d pose = PoseInFrame(view.cam_from_world, total);
      const auto seen = Reproject(calibration.cameras[view.camera], pose, anchor.x_in_world);
      if (!seen) return {};
      const Eigen::Matrix<double, 2, 7> j = seen->by_pose * PoseByGauge(pose);
      h.noalias() += j.transpose() * j;
      g.noalias() += j.transpose() * (seen->x_px - anchor.seed_px);
    }
    const Eigen::LDLT<Eigen::Matrix<double, 7, 7>> solver(h);
    const Eigen::Matrix<double, 7, 1> step = -solver.solve(g);
    if (solver.info() != Eigen::Success || !solver.isPositive() || !step.allFinite()) return {};
    const Similarity3d move{std::exp(step[6]), {ExpRotation(step.head<3>()), step.segment<3>(3)}};
    total.b_from_a = {(move.b_from_a.rotation * total.b_from_a.rotation).normalized(),
                      move * total.b_from_a.translation};
    total.scale *= move.scale;
    if (std::abs(g.dot(step)) < kConverged * kConverged) break;
  }
  return total;
}

}  // namespace rigcal
