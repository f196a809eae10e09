#include "core/rig/residuals.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "core/rig/reprojection.h"
#include "tests/rig/differences.h"

namespace rigcal {
namespace {

Camera DistortedCamera() {
  Camera camera;
  camera.SetIntrinsics((IntrinsicVector() << 1520, 1510, 316, 243, 0.7, -0.11, 0.05, 0.002, -0.0015, 0.01).finished());
  return camera;
}

const Rigid3d kPose{ExpRotation({0.3, -0.5, 0.2}), {0.02, -0.03, 0.6}};
const Eigen::Vector3d kPoint(0.05, -0.04, 0.06);

/// The same residual, differentiated by Ceres: by the 6 of Disturbed() about kPose, to first order.
struct AutoFeature {
  Eigen::Vector2d x_px;
  Eigen::Matrix2d whitening;
  template <typename T>
  bool operator()(const T* intrinsics, const T* delta, const T* point, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Vector x = kPose.rotation.toRotationMatrix().cast<T>() * Vector(point[0], point[1], point[2]) +
                     kPose.translation.cast<T>();
    const Vector w(delta[0], delta[1], delta[2]);
    const Vector moved = x + w.cross(x) + Vector(delta[3], delta[4], delta[5]);
    T seen_px[2];
    ProjectPoint(intrinsics, moved, seen_px);
    const T e0 = seen_px[0] - T(x_px[0]), e1 = seen_px[1] - T(x_px[1]);
    residual[0] = T(whitening(0, 0)) * e0 + T(whitening(0, 1)) * e1;
    residual[1] = T(whitening(1, 0)) * e0 + T(whitening(1, 1)) * e1;
    return true;
  }
};

TEST(FeatureResidual, AgreesWithAutomaticDifferentiation) {
  const Eigen::Vector2d x_px(420, 130);
  const Eigen::Matrix2d whitening = (Eigen::Matrix2d() << 3, 0.4, -0.2, 2).finished();
  const FeatureResidual analytic(x_px, whitening);
  ceres::AutoDiffCostFunction<AutoFeature, 2, kNumIntrinsics, 6, 3> automatic(new AutoFeature{x_px, whitening});
  const IntrinsicVector k = DistortedCamera().Intrinsics();
  const PoseBlock pose = PoseBlockOf(kPose);
  const Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
  const double* a_blocks[] = {k.data(), pose.data(), kPoint.data()};
  const double* b_blocks[] = {k.data(), delta.data(), kPoint.data()};
  Eigen::Vector2d a, b;
  Eigen::Matrix<double, 2, kNumIntrinsics, Eigen::RowMajor> a_k, b_k;
  Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor> a_pose;
  Eigen::Matrix<double, 2, 6, Eigen::RowMajor> b_pose;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> a_point, b_point;
  double* a_jacobians[] = {a_k.data(), a_pose.data(), a_point.data()};
  double* b_jacobians[] = {b_k.data(), b_pose.data(), b_point.data()};
  ASSERT_TRUE(analytic.Evaluate(a_blocks, a.data(), a_jacobians));
  ASSERT_TRUE(automatic.Evaluate(b_blocks, b.data(), b_jacobians));
  EXPECT_LT((a - b).norm(), 1e-9);
  EXPECT_LT((a_k - b_k).norm(), 1e-9 * b_k.norm());
  EXPECT_LT((a_pose.leftCols<6>() - b_pose).norm(), 1e-9 * b_pose.norm());
  EXPECT_LT((a_point - b_point).norm(), 1e-9 * b_point.norm());
}

TEST(Residuals, AgreeWithDifferences) {
  const IntrinsicVector intrinsics = DistortedCamera().Intrinsics();
  const PoseBlock pose_block = PoseBlockOf(kPose);
  const std::vector<double> k(intrinsics.begin(), intrinsics.end()), pose(pose_block.begin(), pose_block.end());
  const PoseManifold manifold;
  CameraPrior prior;
  prior.principal_point_px = {320, 240};
  ExpectDifferencesAgree(IntrinsicsResidual(prior), {nullptr}, {k});
  ExpectDifferencesAgree(AnchorResidual(kPoint, {400, 200}, 6), {nullptr, &manifold}, {k, pose});
  ExpectDifferencesAgree(FeatureResidual({400, 200}, Eigen::Matrix2d::Identity()), {nullptr, &manifold, nullptr},
                         {k, pose, {kPoint.x(), kPoint.y(), kPoint.z()}});
}

TEST(Reproject, PoseDerivativeIsThatOfDisturbed) {
  const Camera camera = DistortedCamera();
  const auto seen = Reproject(camera, kPose, kPoint);
  ASSERT_TRUE(seen);
  for (int k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
    delta[k] = kStep;
    const Eigen::Vector2d plus = *Project(camera, Disturbed(kPose, delta) * kPoint);
    const Eigen::Vector2d minus = *Project(camera, Disturbed(kPose, -delta) * kPoint);
    const Eigen::Vector2d difference = (plus - minus) / (2 * kStep);
    EXPECT_LT((seen->by_pose.col(k) - difference).norm(), 1e-6 * difference.norm()) << k;
  }
  EXPECT_FALSE(Reproject(camera, kPose, {0, 0, -5}));
}

TEST(PoseManifold, MinusUndoesPlus) {
  const PoseBlock x = PoseBlockOf(kPose);
  const Eigen::Matrix<double, 6, 1> delta =
      (Eigen::Matrix<double, 6, 1>() << 0.1, -0.2, 0.05, 0.01, 0.02, -0.03).finished();
  PoseBlock y;
  Eigen::Matrix<double, 6, 1> back;
  const PoseManifold manifold;
  ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), y.data()));
  ASSERT_TRUE(manifold.Minus(y.data(), x.data(), back.data()));
  EXPECT_LT((back - delta).norm(), 1e-12);
}

TEST(AnchorResidual, IsTheShiftInThePictureOverEr) {
  const Camera camera = DistortedCamera();
  const Eigen::Vector2d x_px = *Project(camera, kPose * kPoint);
  const IntrinsicVector k = camera.Intrinsics();
  const PoseBlock pose = PoseBlockOf(kPose);
  const double* blocks[] = {k.data(), pose.data()};
  Eigen::Vector2d residual;
  ASSERT_TRUE(AnchorResidual(kPoint, x_px - Eigen::Vector2d(6, -3), 6).Evaluate(blocks, residual.data(), nullptr));
  EXPECT_LT((residual - Eigen::Vector2d(1, -0.5)).norm(), 1e-12);
}

}  // namespace
}  // namespace rigcal
