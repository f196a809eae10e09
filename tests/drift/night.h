#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/drift/judge_drift.h"
#include "core/rig/camera_information.h"
#include "core/rig/poses_by_rig.h"
#include "core/rig/rig_model_pose.h"
#include "core/rig/rig_prior.h"
#include "tests/adjust/synthetic_rig.h"

/// Nights of a turntable in linear algebra: what an adjustment would find, with the covariance that it would state,
/// without pictures and without an adjustment.
namespace rigcal::synthetic {

inline constexpr double kReleasedRad = 0.02, kReleasedM = 0.02;
inline constexpr double kFeatureSigmaPx = 0.15;

/// What a recording says of the rig, over RigColumns: features alone.
struct RecordedNight {
  RigCalibration placed;
  std::vector<StopPosition> stops;
  std::vector<int> stop_of_view;
  std::vector<ViewPoint> points;
  Eigen::MatrixXd information;
};

inline RigModel StudioModel(int num_cameras) {
  RigModel model = Turntable();
  for (int c = 0; c < num_cameras; ++c) {
    const double azimuth = 0.16 * c, elevation = 0.15 + 0.7 * c / std::max(1, num_cameras - 1);
    const Eigen::Vector3d towards(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                  std::sin(elevation));
    model.cam_from_mount.push_back(LookingAtOrigin(kDistance_m * towards));
  }
  return model;
}

inline std::vector<Camera> StudioCameras(int num_cameras) {
  std::vector<Camera> cameras(num_cameras, StudioCamera());
  for (int c = 0; c < num_cameras; ++c) cameras[c].id = cameras[c].physical_id = "cam" + std::to_string(c);
  return cameras;
}

inline RecordedNight Record(const RigPrior& rig, int num_stops, int num_points, std::uint64_t seed) {
  RecordedNight night;
  night.placed.cameras = rig.cameras;
  for (int s = 0; s < num_stops; ++s) {
    night.stops.push_back({.id = std::to_string(s), .axes = {2 * std::numbers::pi * s / num_stops}});
    for (int c = 0; c < static_cast<int>(rig.cameras.size()); ++c) {
      night.placed.views.push_back({std::to_string(c) + "_" + std::to_string(s), c, {}});
      night.stop_of_view.push_back(s);
    }
  }
  const std::vector<StopError> exact(night.stops.size(), StopError::Zero());
  PlaceViews(rig.model, night.stops, exact, night.stop_of_view, night.placed);
  Random random(seed);
  MeasurementSet measurements;
  for (const SurfacePoint& point : Surface(num_points, random)) {
    std::vector<int> views;
    for (int v = 0; v < night.placed.NumViews(); ++v) {
      if (Faces(night.placed.views[v].cam_from_world, point)) views.push_back(v);
    }
    if (views.size() < 2) continue;
    for (const int v : views) {
      measurements.items.push_back({static_cast<int>(measurements.x_in_world.size()), v, Eigen::Vector2d::Zero(),
                                    Eigen::Matrix2d::Identity() / kFeatureSigmaPx});
      night.points.push_back({v, point.x_in_world});
    }
    measurements.x_in_world.push_back(point.x_in_world);
  }
  const FreeParameters free = AllPinholeParameters(night.placed);
  const Eigen::MatrixXd by_rig = PosesByRig(rig.model, night.stops, exact, night.stop_of_view, night.placed);
  const Eigen::MatrixXd used = by_rig(free.JointRows(), Eigen::all);
  night.information = used.transpose() * FeatureInformation(night.placed, free, measurements) * used;
  return night;
}

/// Everything that is known to some uncertainty, the rig first, and its covariance before the features.
struct KnownBefore {
  std::vector<int> columns;
  Eigen::MatrixXd covariance;
};

inline KnownBefore PriorOf(const RigPrior& rig, const RecordedNight& night) {
  const RigColumns columns{static_cast<int>(rig.cameras.size()), static_cast<int>(night.stops.size())};
  KnownBefore known{rig.FreeRows(), {}};
  const auto num_rig = static_cast<Eigen::Index>(known.columns.size());
  std::vector<double> variances;
  for (int s = 0; s < columns.num_stops; ++s) {
    for (int k = 0; k < kStopErrorSize; ++k) {
      if (!(rig.model.error_sigma[k] > 0)) continue;
      known.columns.push_back(columns.Stop(s) + k);
      variances.push_back(std::pow(rig.model.error_sigma[k], 2));
    }
  }
  const auto size = static_cast<Eigen::Index>(known.columns.size());
  known.covariance = Eigen::MatrixXd::Zero(size, size);
  const std::vector<int> rows = rig.FreeRows();
  known.covariance.topLeftCorner(num_rig, num_rig) = rig.covariance.joint(rows, rows);
  for (std::size_t i = 0; i < variances.size(); ++i) {
    known.covariance(num_rig + static_cast<Eigen::Index>(i), num_rig + static_cast<Eigen::Index>(i)) = variances[i];
  }
  return known;
}

inline Eigen::MatrixXd PosteriorOf(const KnownBefore& known, const RecordedNight& night) {
  const Eigen::MatrixXd features = night.information(known.columns, known.columns);
  return CovarianceFromInformation(features + CovarianceFromInformation(known.covariance));
}

inline void SetCovariance(const std::vector<int>& rows, const Eigen::MatrixXd& covariance, RigCovariance& into) {
  const auto size = static_cast<Eigen::Index>(rows.size());
  into.joint(rows, rows) = covariance.topLeftCorner(size, size);
}

/// A calibration in force as a chart and a recording of twelve stops give it.
inline RigPrior InForce(int num_cameras) {
  constexpr double kChartFocalPx = 0.5, kChartCentrePx = 0.8, kChartRad = 5e-4, kChartM = 3e-4;
  RigPrior rig{StudioCameras(num_cameras), StudioModel(num_cameras), {}};
  const int size = RigCovariance::Size(num_cameras);
  rig.covariance.joint = Eigen::MatrixXd::Zero(size, size);
  for (int c = 0; c < num_cameras; ++c) {
    const int lens = RigCovariance::IntrinsicsRow(c), mount = RigCovariance::MountRow(num_cameras, c);
    auto variance = rig.covariance.joint.diagonal();
    for (const int k : {kFx, kFy}) variance[lens + k] = kChartFocalPx * kChartFocalPx;
    for (const int k : {kCx, kCy}) variance[lens + k] = kChartCentrePx * kChartCentrePx;
    variance.segment<3>(mount).setConstant(kChartRad * kChartRad);
    variance.segment<3>(mount + 3).setConstant(kChartM * kChartM);
  }
  const RecordedNight recorded = Record(rig, 12, 300, 77);
  SetCovariance(rig.FreeRows(), PosteriorOf(PriorOf(rig, recorded), recorded), rig.covariance);
  return rig;
}

inline Eigen::VectorXd NormalVector(Eigen::Index size, Random& random) {
  return Eigen::VectorXd::NullaryExpr(size, [&random] { return random.Normal(); });
}

/// What truly happened since: rows of RigCovariance.
using Happened = Eigen::VectorXd;
inline Happened Nothing(const RigPrior& in_force) {
  return Eigen::VectorXd::Zero(in_force.covariance.joint.rows());
}

/// A camera turned about its own axes.
inline Happened Turned(const RigPrior& in_force, int camera, const Eigen::Vector3d& turn_rad) {
  Happened happened = Nothing(in_force);
  happened.segment<3>(RigCovariance::MountRow(static_cast<int>(in_force.cameras.size()), camera)) = turn_rad;
  return happened;
}

/// All cameras moved by one motion of what carries them.
inline Happened AllMoved(const RigPrior& in_force, const Eigen::Matrix<double, 6, 1>& motion) {
  Happened happened = Nothing(in_force);
  const int n = static_cast<int>(in_force.cameras.size());
  for (int c = 0; c < n; ++c) {
    happened.segment<6>(RigCovariance::MountRow(n, c)) = DisturbanceThrough(*in_force.model.cam_from_mount[c]) * motion;
  }
  return happened;
}

/// Normal, with this covariance, which may be singular.
inline Eigen::VectorXd ScatterOf(const Eigen::MatrixXd& covariance, Random& random) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd scale = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(correlation);
  const Eigen::VectorXd widths = spectrum.eigenvalues().cwiseMax(0).cwiseSqrt();
  return sigma.cwiseProduct(spectrum.eigenvectors() * widths.cwiseProduct(NormalVector(covariance.rows(), random)));
}

/// The judge's input for a night. The truth is drawn from what the calibration in force states, then `happened` to it;
/// stops and features have fresh errors. `noise` 0: everything exact.
inline DriftInput InputFor(const RigPrior& in_force, const RecordedNight& night, const Happened& happened,
                           std::uint64_t seed, double noise = 1) {
  const int n = static_cast<int>(in_force.cameras.size());
  RigPrior released = in_force;
  for (int c = 0; c < n; ++c) LoosenMount(c, kReleasedRad, kReleasedM, released);
  const KnownBefore known = PriorOf(released, night), truth = PriorOf(in_force, night);
  const Eigen::MatrixXd posterior = PosteriorOf(known, night);
  const std::vector<int> rows = in_force.FreeRows();
  Random random(seed);
  const auto size = static_cast<Eigen::Index>(known.columns.size());
  const Eigen::MatrixXd truth_root = truth.covariance.llt().matrixL();
  Eigen::VectorXd departure = noise * (truth_root * NormalVector(size, random));
  departure.head(static_cast<Eigen::Index>(rows.size())) += happened(rows);
  const Eigen::MatrixXd features = night.information(known.columns, known.columns);
  const Eigen::VectorXd found = posterior * (features * departure + noise * ScatterOf(features, random));

  DriftInput input{.in_force = in_force, .released_rad = kReleasedRad, .released_m = kReleasedM};
  input.placed = night.placed, input.stops = night.stops, input.stop_of_view = night.stop_of_view;
  input.points = night.points;
  input.cameras.assign(n, {.num_features = 1000, .before_px = 0.1, .after_px = 0.1});
  input.found.cameras = in_force.cameras;
  input.found.rig = RigEstimate{in_force.model, {"table"}, {in_force.covariance}};
  SetCovariance(rows, posterior, input.found.rig->covariance);
  Eigen::VectorXd delta = Nothing(in_force);
  delta(rows) = found.head(static_cast<Eigen::Index>(rows.size()));
  for (int c = 0; c < n; ++c) {
    input.found.cameras[c].SetIntrinsics(in_force.cameras[c].Intrinsics() +
                                         delta.segment<kNumIntrinsics>(RigCovariance::IntrinsicsRow(c)));
    auto& mount = input.found.rig->model.cam_from_mount[c];
    mount = Disturbed(*mount, delta.segment<6>(RigCovariance::MountRow(n, c)));
  }
  return input;
}

}  // namespace rigcal::synthetic
