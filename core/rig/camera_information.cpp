#include "core/rig/camera_information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/base/ensure.h"
#include "core/rig/reprojection.h"
#include "core/rig/residuals.h"

namespace rigcal {
namespace {

/// The derivative of one or two residual rows by the free parameters they touch.
struct SparseRows {
  std::vector<int> columns;
  Eigen::Matrix<double, 2, Eigen::Dynamic> values;
};

SparseRows CameraRows(const FreeRows& rows, int camera, int view, const Eigen::Matrix2d& whitening,
                      const Reprojection& seen) {
  SparseRows out;
  out.values.resize(2, kNumIntrinsics + 6);
  int n = 0;
  for (int k = 0; k < kNumIntrinsics; ++k) {
    if (rows.intrinsics[camera][k] < 0) continue;
    out.columns.push_back(rows.intrinsics[camera][k]);
    out.values.col(n++) = whitening * seen.by_intrinsics.col(k);
  }
  for (int k = 0; rows.pose[view] >= 0 && k < 6; ++k) {
    out.columns.push_back(rows.pose[view] + k);
    out.values.col(n++) = whitening * seen.by_pose.col(k);
  }
  out.values.conservativeResize(2, n);
  return out;
}

void AddSquare(const SparseRows& rows, Eigen::MatrixXd& information) {
  const Eigen::MatrixXd square = rows.values.transpose() * rows.values;
  for (std::size_t a = 0; a < rows.columns.size(); ++a) {
    for (std::size_t b = 0; b < rows.columns.size(); ++b) information(rows.columns[a], rows.columns[b]) += square(a, b);
  }
}

/// Takes out of the information what went into one point: sum(J_c^T J_p) (sum J_p^T J_p)^-1 sum(J_p^T J_c).
class PointElimination {
 public:
  explicit PointElimination(int num_free) : cross_(Eigen::MatrixXd::Zero(3, num_free)), touched_(num_free, false) {}

  void Add(const SparseRows& rows, const Eigen::Matrix<double, 2, 3>& by_point) {
    point_information_.noalias() += by_point.transpose() * by_point;
    for (std::size_t a = 0; a < rows.columns.size(); ++a) {
      const int column = rows.columns[a];
      if (!touched_[column]) columns_.push_back(column);
      touched_[column] = true;
      cross_.col(column).noalias() += by_point.transpose() * rows.values.col(static_cast<Eigen::Index>(a));
    }
  }

  void SubtractFrom(Eigen::MatrixXd& information) {
    const auto n = static_cast<Eigen::Index>(columns_.size());
    if (n == 0) {  // all its views are fixed
      point_information_.setZero();
      return;
    }
    Eigen::Matrix<double, 3, Eigen::Dynamic> cross(3, n);
    for (Eigen::Index a = 0; a < n; ++a) cross.col(a) = cross_.col(columns_[a]);
    const Eigen::MatrixXd square = cross.transpose() * point_information_.ldlt().solve(cross);
    for (Eigen::Index b = 0; b < n; ++b) {
      for (Eigen::Index a = 0; a < n; ++a) information(columns_[a], columns_[b]) -= square(a, b);
      cross_.col(columns_[b]).setZero();
      touched_[columns_[b]] = false;
    }
    columns_.clear();
    point_information_.setZero();
  }

 private:
  Eigen::Matrix3d point_information_ = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd cross_;
  std::vector<bool> touched_;
  std::vector<int> columns_;
};

}  // namespace

Eigen::MatrixXd FeatureInformation(const RigCalibration& calibration, const FreeParameters& free,
                                   const MeasurementSet& measurements) {
  const FreeRows rows = RowsOf(free);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(rows.count, rows.count);
  PointElimination point(rows.count);
  for (std::size_t i = 0; i < measurements.items.size(); ++i) {
    const Measurement& m = measurements.items[i];
    const View& view = calibration.views[m.view];
    const auto seen =
        Reproject(calibration.cameras[view.camera], view.cam_from_world, measurements.x_in_world[m.point]);
    if (seen) {
      const SparseRows camera_rows = CameraRows(rows, view.camera, m.view, m.whitening, *seen);
      AddSquare(camera_rows, information);
      point.Add(camera_rows, m.whitening * seen->by_point);
    }
    const bool last = i + 1 == measurements.items.size() || measurements.items[i + 1].point != m.point;
    if (last) point.SubtractFrom(information);
  }
  return 0.5 * (information + information.transpose());
}

Eigen::MatrixXd SeedInformation(const RigCalibration& calibration, const FreeParameters& free,
                                std::span<const SeedAnchor> anchors, double sigma_px) {
  Ensure(sigma_px > 0, "the seed's expected error must be positive");
  const FreeRows rows = RowsOf(free);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(rows.count, rows.count);
  for (const SeedAnchor& anchor : anchors) {
    const View& view = calibration.views[anchor.view];
    const auto seen = Reproject(calibration.cameras[view.camera], view.cam_from_world, anchor.x_in_world);
    if (!seen) continue;
    AddSquare(CameraRows(rows, view.camera, anchor.view, Eigen::Matrix2d::Identity() / sigma_px, *seen), information);
  }
  return information;
}

Eigen::MatrixXd IntrinsicsInformation(const RigCalibration& calibration, const FreeParameters& free,
                                      std::span<const CameraPrior> priors) {
  const FreeRows rows = RowsOf(free);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(rows.count, rows.count);
  for (int camera = 0; camera < static_cast<int>(priors.size()); ++camera) {
    const IntrinsicVector intrinsics = calibration.cameras[camera].Intrinsics();
    const double* block = intrinsics.data();
    Eigen::Vector3d residual;
    Eigen::Matrix<double, 3, kNumIntrinsics, Eigen::RowMajor> jacobian;
    double* jacobians[] = {jacobian.data()};
    IntrinsicsResidual(priors[camera]).Evaluate(&block, residual.data(), jacobians);
    const Eigen::Matrix<double, kNumIntrinsics, kNumIntrinsics> square = jacobian.transpose() * jacobian;
    for (int a = 0; a < kNumIntrinsics; ++a) {
      for (int b = 0; b < kNumIntrinsics; ++b) {
        const int row = rows.intrinsics[camera][a], column = rows.intrinsics[camera][b];
        if (row >= 0 && column >= 0) information(row, column) += square(a, b);
      }
    }
  }
  return information;
}

Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& information) {
  if (information.rows() == 0) return information;
  constexpr double kMinRelativeEigenvalue = 1e-13;
  const Eigen::VectorXd scale =
      information.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(scaled);
  const double floor = kMinRelativeEigenvalue * spectrum.eigenvalues().maxCoeff();
  const Eigen::VectorXd sigmas = spectrum.eigenvalues().cwiseMax(floor).cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * spectrum.eigenvectors() * sigmas.asDiagonal();
}

Eigen::MatrixXd CovarianceFromInformation(const Eigen::MatrixXd& information) {
  const Eigen::MatrixXd root = CovarianceRoot(information);
  return root * root.transpose();
}

}  // namespace rigcal
