#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/rig/camera_information.h"
#include "core/rig/gauge.h"
#include "core/rig/reprojection.h"
#include "core/rig/residuals.h"
#include "core/scene/rig_calibration.h"
#include "core/scene/track.h"

/// Cameras round an object of about 15 cm, its surface points, and what the cameras see of them.
namespace rigcal::synthetic {

inline constexpr double kObjectRadius_m = 0.075;
inline constexpr double kDistance_m = 0.6;

inline Camera StudioCamera() {
  Camera camera;
  camera.id = camera.physical_id = "cam";
  camera.width_px = 640, camera.height_px = 480;
  camera.fx_px = camera.fy_px = 1520;
  camera.cx_px = 316, camera.cy_px = 243;
  return camera;
}

/// Looks at the world's origin; world z points up in the picture.
inline Rigid3d LookingAtOrigin(const Eigen::Vector3d& centre_in_world) {
  const Eigen::Vector3d forward = -centre_in_world.normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d r;
  r << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  return {Eigen::Quaterniond(r), -(r * centre_in_world)};
}

/// `count` views on a full circle about z, `elevation_rad` above the object.
inline RigCalibration Ring(int count, double elevation_rad = 0.3) {
  RigCalibration rig;
  rig.cameras = {StudioCamera()};
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const Eigen::Vector3d direction(std::cos(elevation_rad) * std::cos(angle),
                                    std::cos(elevation_rad) * std::sin(angle), std::sin(elevation_rad));
    rig.views.push_back({"ring" + std::to_string(i), 0, LookingAtOrigin(kDistance_m * direction)});
  }
  return rig;
}

/// `count` views over the upper half of a sphere (a Fibonacci spiral), at distances between 0.9 and 1.1 times the mean.
inline RigCalibration Hemisphere(int count) {
  RigCalibration rig;
  rig.cameras = {StudioCamera()};
  for (int i = 0; i < count; ++i) {
    const double z = 0.05 + 0.85 * i / (count - 1);
    const double angle = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
    const Eigen::Vector3d direction(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    const double distance_m = kDistance_m * (0.9 + 0.1 * (i % 3));
    rig.views.push_back({"sphere" + std::to_string(i), 0, LookingAtOrigin(distance_m * direction)});
  }
  return rig;
}

/// Gives every view a camera of its own.
inline RigCalibration CameraPerView(RigCalibration rig) {
  const std::vector<Camera> shared = rig.cameras;
  rig.cameras.clear();
  for (View& view : rig.views) {
    rig.cameras.push_back(shared[view.camera]);
    view.camera = static_cast<int>(rig.cameras.size()) - 1;
  }
  return rig;
}

struct SurfacePoint {
  Eigen::Vector3d x_in_world;
  Eigen::Vector3d normal_in_world;
};

/// Points on a bumpy ball.
inline std::vector<SurfacePoint> Surface(int count, Random& random) {
  std::vector<SurfacePoint> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d n = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    points.push_back({kObjectRadius_m * random.Uniform(0.8, 1.0) * n, n});
  }
  return points;
}

/// Whether a view sees a point from within 70 degrees of its normal.
inline bool Faces(const Rigid3d& cam_from_world, const SurfacePoint& point) {
  constexpr double kMinCosine = 0.34;
  const Eigen::Vector3d towards = (CentreInWorld(cam_from_world) - point.x_in_world).normalized();
  return towards.dot(point.normal_in_world) > kMinCosine;
}

struct ObservationNoise {
  double sigma_px = 0.3;
  double outlier_share = 0;
  double outlier_px = 20;  ///< outliers lie evenly within this many pixels of the truth
};

/// What the views that face a point see of it; tracks of at least two.
inline TrackSet Observe(const RigCalibration& rig, const std::vector<SurfacePoint>& surface,
                        const ObservationNoise& noise, Random& random) {
  TrackSet set;
  for (const SurfacePoint& point : surface) {
    Track track;
    track.x_in_world = point.x_in_world;
    for (int v = 0; v < rig.NumViews(); ++v) {
      const Rigid3d& pose = rig.views[v].cam_from_world;
      if (!Faces(pose, point)) continue;
      Eigen::Vector2d x_px = *Project(rig.CameraOf(v), pose * point.x_in_world);
      if (random.Uniform() < noise.outlier_share) {
        x_px += noise.outlier_px * Eigen::Vector2d(random.Uniform(-1, 1), random.Uniform(-1, 1));
      } else {
        x_px += noise.sigma_px * Eigen::Vector2d(random.Normal(), random.Normal());
      }
      track.observations.push_back({v, x_px, Eigen::Matrix2d::Identity(), 1});
    }
    if (track.observations.size() >= 2) set.tracks.push_back(std::move(track));
  }
  return set;
}

inline std::vector<CameraPrior> PriorsOf(const RigCalibration& rig, double aspect_sigma) {
  std::vector<CameraPrior> priors;
  for (const Camera& camera : rig.cameras) {
    CameraPrior prior;
    prior.aspect = camera.fx_px / camera.fy_px;
    prior.aspect_sigma = aspect_sigma;
    prior.principal_point_px = {camera.cx_px, camera.cy_px};
    priors.push_back(prior);
  }
  return priors;
}

/// The calibration with delta (rows as in CalibrationCovariance) added.
inline RigCalibration Moved(const RigCalibration& rig, const Eigen::VectorXd& delta) {
  RigCalibration moved = rig;
  for (int c = 0; c < rig.NumCameras(); ++c) {
    moved.cameras[c].SetIntrinsics(rig.cameras[c].Intrinsics() +
                                   delta.segment<kNumIntrinsics>(CalibrationCovariance::IntrinsicsRow(c)));
  }
  for (int v = 0; v < rig.NumViews(); ++v) {
    moved.views[v].cam_from_world =
        Disturbed(rig.views[v].cam_from_world, delta.segment<6>(CalibrationCovariance::PoseRow(rig.NumCameras(), v)));
  }
  return moved;
}

/// The inverse of Moved: `to` minus `from`.
inline Eigen::VectorXd Difference(const RigCalibration& to, const RigCalibration& from) {
  Eigen::VectorXd delta(CalibrationCovariance::PoseRow(from.NumCameras(), from.NumViews()));
  for (int c = 0; c < from.NumCameras(); ++c) {
    delta.segment<kNumIntrinsics>(CalibrationCovariance::IntrinsicsRow(c)) =
        to.cameras[c].Intrinsics() - from.cameras[c].Intrinsics();
  }
  for (int v = 0; v < from.NumViews(); ++v) {
    const Rigid3d& a = to.views[v].cam_from_world;
    const Rigid3d& b = from.views[v].cam_from_world;
    const Eigen::Quaterniond turn = a.rotation * b.rotation.conjugate();
    const int row = CalibrationCovariance::PoseRow(from.NumCameras(), v);
    delta.segment<3>(row) = LogRotation(turn);
    delta.segment<3>(row + 3) = a.translation - turn * b.translation;
  }
  return delta;
}

/// The seed as the adjustment believes in it.
struct Prior {
  RigCalibration seed;
  FreeParameters free;
  std::vector<SeedAnchor> anchors;
  double expected_error_px;
  std::vector<CameraPrior> camera_priors;
};

inline Prior PriorAbout(const RigCalibration& seed, const TrackSet& tracks, double expected_error_px,
                        double aspect_sigma) {
  return {seed, AllPinholeParameters(seed), ChooseSeedAnchors({seed, expected_error_px}, tracks), expected_error_px,
          PriorsOf(seed, aspect_sigma)};
}

/// Residuals of the prior at `rig`, in sigmas, and their derivative by the free vector.
inline std::pair<Eigen::VectorXd, Eigen::MatrixXd> PriorResiduals(const Prior& prior, const RigCalibration& rig) {
  const FreeRows rows = RowsOf(prior.free);
  const auto num_anchors = static_cast<Eigen::Index>(prior.anchors.size());
  Eigen::VectorXd r(2 * num_anchors + 3 * rig.NumCameras());
  Eigen::MatrixXd j = Eigen::MatrixXd::Zero(r.size(), rows.count);
  for (Eigen::Index i = 0; i < num_anchors; ++i) {
    const SeedAnchor& anchor = prior.anchors[static_cast<std::size_t>(i)];
    const View& view = rig.views[anchor.view];
    const Reprojection seen = *Reproject(rig.cameras[view.camera], view.cam_from_world, anchor.x_in_world);
    r.segment<2>(2 * i) = (seen.x_px - anchor.seed_px) / prior.expected_error_px;
    for (int k = 0; k < 6; ++k) {
      j.block<2, 1>(2 * i, rows.pose[anchor.view] + k) = seen.by_pose.col(k) / prior.expected_error_px;
    }
    for (const int k : {kFx, kFy, kCx, kCy}) {
      j.block<2, 1>(2 * i, rows.intrinsics[view.camera][k]) = seen.by_intrinsics.col(k) / prior.expected_error_px;
    }
  }
  for (int c = 0; c < rig.NumCameras(); ++c) {
    const IntrinsicVector intrinsics = rig.cameras[c].Intrinsics();
    const double* block = intrinsics.data();
    Eigen::Matrix<double, 3, kNumIntrinsics, Eigen::RowMajor> by_intrinsics;
    double* jacobians[] = {by_intrinsics.data()};
    IntrinsicsResidual(prior.camera_priors[c]).Evaluate(&block, r.data() + 2 * num_anchors + 3 * c, jacobians);
    for (const int k : {kFx, kFy, kCx, kCy}) {
      j.block<3, 1>(2 * num_anchors + 3 * c, rows.intrinsics[c][k]) = by_intrinsics.col(k);
    }
  }
  return {r, j};
}

/// Cameras drawn from the prior: every residual gets a normal error and the cameras that fit them best are found. For
/// small errors this is N(seed, (SeedInformation + IntrinsicsInformation)^-1); for large ones it follows the picture,
/// where the prior is normal, and not the tangent of the parameters.
inline RigCalibration DrawFromPrior(const Prior& prior, Random& random) {
  constexpr int kIterations = 8;
  RigCalibration drawn = prior.seed;
  Eigen::VectorXd target;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const auto [r, j] = PriorResiduals(prior, drawn);
    if (iteration == 0) target = r + Eigen::VectorXd::NullaryExpr(r.size(), [&random] { return random.Normal(); });
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(CalibrationCovariance::PoseRow(drawn.NumCameras(), drawn.NumViews()));
    const Eigen::VectorXd gradient = j.transpose() * (target - r);
    delta(prior.free.JointRows()) = CovarianceFromInformation(j.transpose() * j) * gradient;
    drawn = Moved(drawn, delta);
  }
  return drawn;
}

/// Mean distance between the projections by both of the points that each view sees, after the best similarity alignment
/// of the estimate.
inline double TruthErrorPx(const RigCalibration& truth, const RigCalibration& estimate,
                           const std::vector<SurfacePoint>& surface) {
  std::vector<SeedAnchor> anchors;
  for (int v = 0; v < truth.NumViews(); ++v) {
    for (std::size_t i = 0; i < surface.size(); i += 1 + surface.size() / 300) {
      const Eigen::Vector3d& x = surface[i].x_in_world;
      if (!Faces(truth.views[v].cam_from_world, surface[i])) continue;
      anchors.push_back({v, x, *Project(truth.CameraOf(v), truth.views[v].cam_from_world * x)});
    }
  }
  const RigCalibration aligned = InFrame(estimate, AlignmentToSeed(estimate, anchors));
  double sum_px = 0;
  for (const SeedAnchor& a : anchors) {
    const auto x_px = Project(aligned.CameraOf(a.view), aligned.views[a.view].cam_from_world * a.x_in_world);
    sum_px += (*x_px - a.seed_px).norm();
  }
  return sum_px / static_cast<double>(anchors.size());
}

}  // namespace rigcal::synthetic
