#include "tests/validate/object_scene.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "tests/validate/cameras_for_test.h"

namespace rigcal::test {
namespace {

constexpr double kDistance = 0.8;  // metres
const Eigen::Vector3d kHalfAxes(0.08, 0.08, 0.12);

Camera SquareCamera(const std::string& id) {
  return {.id = id,
          .physical_id = id,
          .width_px = 1280,
          .height_px = 1024,
          .fx_px = 1800,
          .fy_px = 1800,
          .cx_px = 645,
          .cy_px = 505};
}

RigCalibration TrueCameras(const SceneOptions& options) {
  RigCalibration truth;
  truth.unit = LengthUnit::kMetre;
  const bool two = options.motion == Motion::kTwoCameraTurntable;
  truth.cameras.push_back(SquareCamera("cam0"));
  if (two) truth.cameras.push_back(SquareCamera("cam1"));
  for (int i = 0; i < options.num_views; ++i) {
    double azimuth_rad = 2 * std::numbers::pi * i / options.num_views, elevation_rad = 0.35;
    if (two) elevation_rad = i % 2 == 0 ? 0.2 : 0.6;
    if (options.motion == Motion::kHemisphere) {
      azimuth_rad = 2.39996 * i;  // the golden angle
      elevation_rad = std::asin(0.1 + 0.8 * i / (options.num_views - 1));
    }
    const Eigen::Vector3d direction(std::cos(azimuth_rad) * std::cos(elevation_rad),
                                    std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad));
    truth.views.push_back({fmt::format("view{:02}", i), two ? i % 2 : 0,
                           LookingAt(kDistance * direction, Eigen::Vector3d(0, 0, 0.002 * (i % 3)))});
  }
  return truth;
}

Eigen::Vector3d RandomNormal(Random* random) {
  return {random->Normal(), random->Normal(), random->Normal()};
}

std::vector<ComparePoint> FacingPoints(const RigCalibration& truth, int num_points, Random* random) {
  constexpr double kMinCosine = 0.5;
  std::vector<ComparePoint> points;
  while (static_cast<int>(points.size()) < num_points) {
    const Eigen::Vector3d unit = RandomNormal(random).normalized();
    ComparePoint point{unit.cwiseProduct(kHalfAxes), {}};
    const Eigen::Vector3d normal = unit.cwiseQuotient(kHalfAxes).normalized();
    for (int j = 0; j < truth.NumViews(); ++j) {
      const Eigen::Vector3d to_camera = CentreInWorld(truth.views[j].cam_from_world) - point.x_in_world;
      if (normal.dot(to_camera.normalized()) > kMinCosine) point.views.push_back(j);
    }
    if (point.views.size() >= 2) points.push_back(point);
  }
  return points;
}

/// Intrinsics and pose of a 3x4 matrix: M = K R with K upper triangular, positive diagonal.
void Decompose(const Eigen::Matrix<double, 3, 4>& px_from_world, Camera* camera, Rigid3d* cam_from_world) {
  Eigen::Matrix<double, 3, 4> p = px_from_world;
  if (p.leftCols<3>().determinant() < 0) p = -p;
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(p.leftCols<3>().inverse());
  const Eigen::Matrix3d q = qr.householderQ();
  const Eigen::Matrix3d upper = qr.matrixQR().triangularView<Eigen::Upper>();
  const Eigen::Vector3d signs = upper.diagonal().array().sign();
  const Eigen::Matrix3d k = (signs.asDiagonal() * upper).inverse();
  const Eigen::Matrix3d r = (q * signs.asDiagonal()).transpose();
  camera->fx_px = k(0, 0) / k(2, 2), camera->fy_px = k(1, 1) / k(2, 2), camera->skew_px = k(0, 1) / k(2, 2);
  camera->cx_px = k(0, 2) / k(2, 2), camera->cy_px = k(1, 2) / k(2, 2);
  cam_from_world->rotation = Eigen::Quaterniond(r).normalized();
  cam_from_world->translation = k.inverse() * p.col(3);
}

RigCalibration BentBy(const RigCalibration& calibration, const Eigen::Matrix4d& bent_from_world, BentAs as) {
  RigCalibration bent = calibration;
  bent.cameras.clear();
  for (int j = 0; j < calibration.NumViews(); ++j) {
    Camera camera = calibration.CameraOf(j);
    Decompose(ProjectionMatrix(camera, calibration.views[j].cam_from_world, 0) * bent_from_world, &camera,
              &bent.views[j].cam_from_world);
    camera.id += fmt::format("_{}", j);
    bent.cameras.push_back(camera);
    bent.views[j].camera = j;
  }
  if (as == BentAs::kCamerasPerView) return bent;
  std::vector<Camera> shared = calibration.cameras;
  for (int c = 0; c < calibration.NumCameras(); ++c) {
    IntrinsicVector median = IntrinsicVector::Zero();
    for (const int k : {kFx, kFy, kCx, kCy}) {
      std::vector<double> values;
      for (int j = 0; j < calibration.NumViews(); ++j) {
        if (calibration.views[j].camera == c) values.push_back(bent.cameras[j].Intrinsics()[k]);
      }
      std::sort(values.begin(), values.end());
      median[k] = values[values.size() / 2];
    }
    shared[c].SetIntrinsics(median);
  }
  bent.cameras = shared;
  for (int j = 0; j < calibration.NumViews(); ++j) bent.views[j].camera = calibration.views[j].camera;
  return bent;
}

}  // namespace

TrackSet MeasuredTracks(const RigCalibration& truth, const std::vector<ComparePoint>& points,
                        const SceneOptions& options) {
  constexpr double kOutlierPx = 8;
  Random random(DeriveSeed(options.random_seed, 2));
  TrackSet tracks;
  for (const ComparePoint& point : points) {
    Track track;
    track.x_in_world = point.x_in_world;
    track.held_out = random.Uniform() < options.held_out_share;
    for (const int j : point.views) {
      auto x_px = Project(truth.CameraOf(j), truth.views[j].cam_from_world * point.x_in_world);
      if (!x_px) continue;
      *x_px += options.noise_px * Eigen::Vector2d(random.Normal(), random.Normal());
      if (random.Uniform() < options.outlier_share) {
        *x_px += Eigen::Vector2d(random.Uniform(-kOutlierPx, kOutlierPx), random.Uniform(-kOutlierPx, kOutlierPx));
      }
      track.observations.push_back({j, *x_px, Eigen::Matrix2d::Identity(), 0.9F});
    }
    if (track.observations.size() >= 2) tracks.tracks.push_back(track);
  }
  return tracks;
}

ObjectScene MakeScene(const SceneOptions& options) {
  ObjectScene scene;
  scene.truth = TrueCameras(options);
  Random random(DeriveSeed(options.random_seed, 1));
  scene.points = FacingPoints(scene.truth, options.num_points, &random);
  scene.tracks = MeasuredTracks(scene.truth, scene.points, options);
  return scene;
}

double ErrorPx(const RigCalibration& truth, const RigCalibration& estimate, const std::vector<ComparePoint>& points) {
  const auto report = CompareCameras(truth, estimate, points, CompareAlignment::kSimilarity);
  return report ? report->mean_px : std::nan("");
}

RigCalibration Bent(const RigCalibration& calibration, const std::vector<ComparePoint>& points, double target_px,
                    BentAs as, BendEntries entries, std::uint64_t random_seed) {
  Random random(random_seed);
  Eigen::Matrix4d change;
  for (int k = 0; k < 16; ++k) change(k / 4, k % 4) = random.Normal();
  if (entries == BendEntries::kPlaneAtInfinity) change.topRows<3>().setZero(), change(3, 3) = 0;
  if (entries == BendEntries::kAffine) change.row(3).setZero();
  // In a frame about the object, of its size, so that all entries matter.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ComparePoint& p : points) mean += p.x_in_world / static_cast<double>(points.size());
  double size2 = 0;
  for (const ComparePoint& p : points)
    size2 += (p.x_in_world - mean).squaredNorm() / static_cast<double>(points.size());
  Eigen::Matrix4d unit_from_world = Eigen::Matrix4d::Identity();
  unit_from_world.topLeftCorner<3, 3>() /= std::sqrt(size2);
  unit_from_world.topRightCorner<3, 1>() = -mean / std::sqrt(size2);
  std::vector<ComparePoint> some;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 100) some.push_back(points[i]);
  const auto bent_by = [&](double strength) {
    const Eigen::Matrix4d in_unit = Eigen::Matrix4d::Identity() + strength * change;
    return BentBy(calibration, unit_from_world.inverse() * in_unit * unit_from_world, as);
  };
  double strength = 1e-3;
  for (int iteration = 0; iteration < 10; ++iteration) {
    const double error_px = ErrorPx(calibration, bent_by(strength), some);
    if (std::abs(error_px / target_px - 1) < 0.01) break;
    strength *= std::clamp(target_px / error_px, 0.2, 5.0);
  }
  return bent_by(strength);
}

}  // namespace rigcal::test
