#include "core/rig/camera_information.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/rig/gauge.h"
#include "core/rig/projection_uncertainty.h"
#include "tests/adjust/synthetic_rig.h"

namespace rigcal {
namespace {

using namespace synthetic;

struct Fixture {
  Random random{3};
  RigCalibration rig = Hemisphere(5);
  std::vector<SurfacePoint> surface = Surface(60, random);
  TrackSet tracks = Observe(rig, surface, {.sigma_px = 0}, random);
  FreeParameters free = AllPinholeParameters(rig);
  MeasurementSet measurements = MeasurementsOf(rig, tracks, {});
};

// Schur complement of the whole normal matrix, formed the plain way.
TEST(FeatureInformation, IsTheSchurComplement) {
  Fixture f;
  const FreeRows rows = RowsOf(f.free);
  const auto num_points = static_cast<Eigen::Index>(f.measurements.x_in_world.size());
  const Eigen::Index size = rows.count + 3 * num_points;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  for (const Measurement& m : f.measurements.items) {
    const auto seen =
        Reproject(f.rig.CameraOf(m.view), f.rig.views[m.view].cam_from_world, f.measurements.x_in_world[m.point]);
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(2, size);
    for (const int k : {kFx, kFy, kCx, kCy}) j.col(rows.intrinsics[0][k]) = seen->by_intrinsics.col(k);
    j.middleCols<6>(rows.pose[m.view]) = seen->by_pose;
    j.middleCols<3>(rows.count + 3 * m.point) = seen->by_point;
    j = m.whitening * j;
    normal += j.transpose() * j;
  }
  const Eigen::Index c = rows.count, p = 3 * num_points;
  const Eigen::MatrixXd schur =
      normal.topLeftCorner(c, c) -
      normal.topRightCorner(c, p) * normal.bottomRightCorner(p, p).ldlt().solve(normal.bottomLeftCorner(p, c));
  const Eigen::MatrixXd information = FeatureInformation(f.rig, f.free, f.measurements);
  EXPECT_LT((information - schur).norm(), 1e-9 * schur.norm());
}

TEST(GaugeDirections, AreWhatNoFeatureSees) {
  Fixture f;
  const std::vector<int> rows = f.free.JointRows();
  const Eigen::MatrixXd g = GaugeDirections(f.rig)(rows, Eigen::all);
  const Eigen::MatrixXd information = FeatureInformation(f.rig, f.free, f.measurements);
  EXPECT_LT((information * g).norm(), 1e-8 * information.norm() * g.norm());
  // And they are the derivative of InFrame.
  const double step = 1e-6;
  const RigCalibration turned = InFrame(f.rig, {1, {ExpRotation({0, step, 0}), {0, 0, 0}}});
  const RigCalibration shifted = InFrame(f.rig, {1, {Eigen::Quaterniond::Identity(), {step, 0, 0}}});
  const RigCalibration grown = InFrame(f.rig, {1 + step, {}});
  const auto expect_column = [&f, step](const RigCalibration& moved, int column) {
    const Eigen::VectorXd difference = Difference(moved, f.rig) / step;
    EXPECT_LT((difference - GaugeDirections(f.rig).col(column)).norm(), 1e-5 * difference.norm()) << column;
  };
  expect_column(turned, 1);
  expect_column(shifted, 3);
  expect_column(grown, 6);
}

TEST(AlignmentToSeed, FindsTheFrame) {
  Fixture f;
  const auto anchors = ChooseSeedAnchors({f.rig, 6}, f.tracks);
  ASSERT_EQ(anchors.size(), 5u * 12u);
  const Similarity3d away{0.8, {ExpRotation({0.1, 0.2, -0.1}), {0.02, 0.01, 0.03}}};
  const RigCalibration moved = InFrame(f.rig, away);
  for (const SeedAnchor& a : anchors) {  // a frame changes no picture
    const auto x_px = Project(moved.CameraOf(a.view), moved.views[a.view].cam_from_world * (away * a.x_in_world));
    EXPECT_LT((*x_px - a.seed_px).norm(), 1e-9);
  }
  EXPECT_LT(Difference(InFrame(moved, AlignmentToSeed(moved, anchors)), f.rig).norm(), 1e-9);
}

TEST(CovarianceFromInformation, InvertsAcrossUnits) {
  const Eigen::Vector3d scale(1e6, 1, 1e-5);
  Eigen::Matrix3d unit;
  unit << 1, 0.5, 0.2, 0.5, 1, 0.3, 0.2, 0.3, 1;
  const Eigen::Matrix3d information = scale.asDiagonal() * unit * scale.asDiagonal();
  const Eigen::Matrix3d product = information * CovarianceFromInformation(information);
  EXPECT_LT((scale.cwiseInverse().asDiagonal() * product * scale.asDiagonal() - Eigen::Matrix3d::Identity()).norm(),
            1e-12);
}

TEST(ProjectionSigmaPx, IsBlindToTheGaugeAndSeesTheRest) {
  Fixture f;
  const auto points = ObjectViewPoints(f.rig, f.tracks, 100);
  const auto g = GaugeDirections(f.rig);
  f.rig.covariance = CalibrationCovariance{g * g.transpose()};
  for (const double sigma_px : ProjectionSigmaPx(f.rig, points)) EXPECT_LT(sigma_px, 1e-3);
  // Only the principal point uncertain, by 1 px: turning the world takes some of it back, in no view all.
  f.rig.covariance->joint.setZero();
  f.rig.covariance->joint.diagonal().array() = 1e-30;  // nothing is held fixed
  f.rig.covariance->joint(kCx, kCx) = f.rig.covariance->joint(kCy, kCy) = 1;
  for (const double sigma_px : ProjectionSigmaPx(f.rig, points)) {
    EXPECT_GT(sigma_px, 0.2);
    EXPECT_LT(sigma_px, 1.5);
  }
}

TEST(WeakestDirectionsPx, KnowsThatARingDoesNotHoldItsAspect) {
  const auto weakest = [](RigCalibration rig) {
    Random random(1);
    const TrackSet tracks = Observe(rig, Surface(500, random), {.sigma_px = 0}, random);
    const FreeParameters free = AllPinholeParameters(rig);
    return WeakestDirectionsPx(rig, free, FeatureInformation(rig, free, MeasurementsOf(rig, tracks, {})),
                               ObjectViewPoints(rig, tracks, 100), 3);
  };
  const auto ring = weakest(Ring(16)), sphere = weakest(Hemisphere(16));
  ASSERT_EQ(ring.size(), 3u);
  EXPECT_GT(ring[0], 2);
  EXPECT_LT(sphere[0], 0.1);
  EXPECT_GE(ring[0], ring[1]);
}

}  // namespace
}  // namespace rigcal
