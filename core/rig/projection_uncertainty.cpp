#include "core/rig/projection_uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/ensure.h"
#include "core/rig/camera_information.h"
#include "core/rig/gauge.h"
#include "core/rig/reprojection.h"

namespace rigcal {
namespace {

constexpr int kViewParameters = kNumIntrinsics + 6;
using ViewMetric = Eigen::Matrix<double, kViewParameters, kViewParameters>;

/// Mean over a view's points of J^T J, by the view's intrinsics and pose: delta^T M delta is its mean squared motion.
struct ImageMotion {
  std::vector<ViewMetric> per_view;
  std::vector<int> num_points;
};

ImageMotion MotionOf(const RigCalibration& calibration, std::span<const ViewPoint> points) {
  ImageMotion motion{std::vector<ViewMetric>(calibration.views.size(), ViewMetric::Zero()),
                     std::vector<int>(calibration.views.size(), 0)};
  for (const ViewPoint& point : points) {
    const View& view = calibration.views[point.view];
    const auto seen = Reproject(calibration.cameras[view.camera], view.cam_from_world, point.x_in_world);
    if (!seen) continue;
    Eigen::Matrix<double, 2, kViewParameters> j;
    j << seen->by_intrinsics, seen->by_pose;
    motion.per_view[point.view].noalias() += j.transpose() * j;
    ++motion.num_points[point.view];
  }
  for (std::size_t v = 0; v < motion.per_view.size(); ++v) motion.per_view[v] /= std::max(1, motion.num_points[v]);
  return motion;
}

/// Joint rows of one view's intrinsics and pose.
std::array<int, kViewParameters> ViewRows(const RigCalibration& calibration, int view) {
  std::array<int, kViewParameters> rows{};
  for (int k = 0; k < kNumIntrinsics; ++k) {
    rows[k] = CalibrationCovariance::IntrinsicsRow(calibration.views[view].camera) + k;
  }
  for (int k = 0; k < 6; ++k) {
    rows[kNumIntrinsics + k] = CalibrationCovariance::PoseRow(calibration.NumCameras(), view) + k;
  }
  return rows;
}

/// delta^T M delta is the mean squared motion over all views with points; rows as in CalibrationCovariance.
Eigen::MatrixXd JointMetric(const RigCalibration& calibration, const ImageMotion& motion) {
  const int size = CalibrationCovariance::PoseRow(calibration.NumCameras(), calibration.NumViews());
  Eigen::MatrixXd metric = Eigen::MatrixXd::Zero(size, size);
  const auto num_seen = std::count_if(motion.num_points.begin(), motion.num_points.end(), [](int n) { return n > 0; });
  for (int view = 0; view < calibration.NumViews(); ++view) {
    const auto rows = ViewRows(calibration, view);
    metric(rows, rows) += motion.per_view[view] / static_cast<double>(std::max<std::ptrdiff_t>(1, num_seen));
  }
  return metric;
}

/// Takes from a parameter vector its best similarity alignment, measured by the metric: I - G (G^T M G)^-1 G^T M.
Eigen::MatrixXd WithoutGauge(const RigCalibration& calibration, const Eigen::MatrixXd& metric) {
  const auto g = GaugeDirections(calibration);
  const Eigen::Matrix<double, 7, Eigen::Dynamic> gm = g.transpose() * metric;
  const Eigen::Matrix<double, 7, 7> gmg = gm * g;
  return Eigen::MatrixXd::Identity(metric.rows(), metric.cols()) - g * gmg.ldlt().solve(gm);
}

bool AnyPoseHeld(const RigCalibration& calibration) {
  for (int view = 0; view < calibration.NumViews(); ++view) {
    const int row = CalibrationCovariance::PoseRow(calibration.NumCameras(), view);
    if (calibration.covariance->joint.block<6, 6>(row, row).isZero(0)) return true;
  }
  return false;
}

}  // namespace

std::vector<ViewPoint> ObjectViewPoints(const RigCalibration& calibration, const TrackSet& tracks, int max_per_view) {
  std::vector<ViewPoint> points;
  for (int view = 0; view < calibration.NumViews(); ++view) {
    std::vector<const Track*> seen;
    for (const Track& track : tracks.tracks) {
      if (std::any_of(track.observations.begin(), track.observations.end(),
                      [view](const Observation& o) { return o.view == view; })) {
        seen.push_back(&track);
      }
    }
    if (seen.empty()) {
      for (const Track& track : tracks.tracks) seen.push_back(&track);
    }
    const std::size_t step = 1 + seen.size() / static_cast<std::size_t>(std::max(1, max_per_view));
    for (std::size_t i = 0; i < seen.size(); i += step) points.push_back({view, seen[i]->x_in_world});
  }
  return points;
}

std::vector<double> ProjectionSigmaPx(const RigCalibration& calibration, std::span<const ViewPoint> points) {
  Ensure(calibration.covariance.has_value(), "the uncertainty in pixels needs a covariance");
  const ImageMotion motion = MotionOf(calibration, points);
  Eigen::MatrixXd covariance = calibration.covariance->joint;
  if (!AnyPoseHeld(calibration)) {
    const Eigen::MatrixXd aligned = WithoutGauge(calibration, JointMetric(calibration, motion));
    covariance = aligned * covariance * aligned.transpose();
  }
  std::vector<double> sigma_px(calibration.views.size(), 0.0);
  for (int view = 0; view < calibration.NumViews(); ++view) {
    const auto rows = ViewRows(calibration, view);
    const ViewMetric own = covariance(rows, rows);
    sigma_px[view] = std::sqrt(std::max(0.0, (motion.per_view[view] * own).trace()));
  }
  return sigma_px;
}

std::vector<double> WeakestDirectionsPx(const RigCalibration& calibration, const FreeParameters& free,
                                        const Eigen::MatrixXd& feature_information, std::span<const ViewPoint> points,
                                        int count) {
  const Eigen::MatrixXd joint_metric = JointMetric(calibration, MotionOf(calibration, points));
  const std::vector<int> rows = free.JointRows();
  Eigen::MatrixXd metric = joint_metric(rows, rows);
  Eigen::MatrixXd information = feature_information;
  if (!free.AnyPoseFixed()) {
    // Along the gauge the features say nothing and the aligned motion is nothing: any information makes it drop out.
    const Eigen::MatrixXd g = GaugeDirections(calibration)(rows, Eigen::all);
    const Eigen::MatrixXd mg = metric * g;
    const Eigen::MatrixXd pin = mg * (g.transpose() * mg).ldlt().solve(mg.transpose());
    metric -= pin;
    information += pin;
  }
  // The motion's eigenvalues are those of R^T M R with covariance = R R^T.
  const Eigen::MatrixXd root = CovarianceRoot(information);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(root.transpose() * metric * root,
                                                                Eigen::EigenvaluesOnly);
  std::vector<double> sigma_px;
  for (Eigen::Index i = spectrum.eigenvalues().size(); i-- > 0 && static_cast<int>(sigma_px.size()) < count;) {
    sigma_px.push_back(std::sqrt(std::max(0.0, spectrum.eigenvalues()[i])));
  }
  return sigma_px;
}

}  // namespace rigcal
