#include "core/geometry/camera.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"
#include "core/geometry/triangulate.h"

namespace rigcal {
namespace {

Camera DistortedCamera() {
  Camera c;
  c.width_px = 1280, c.height_px = 960;
  c.fx_px = 1500, c.fy_px = 1490, c.cx_px = 650, c.cy_px = 470;
  c.k1 = -0.12, c.k2 = 0.08, c.p1 = 0.001, c.p2 = -0.0007, c.k3 = -0.02;
  return c;
}

TEST(Camera, ProjectsAsTheFormulaInItsHeaderSays) {
  Camera c = DistortedCamera();
  // By hand for (x, y) = (0.2, -0.1), r2 = 0.05: radial = 0.994195 + ..., see the header.
  const double r2 = 0.05, radial = 1 + c.k1 * r2 + c.k2 * r2 * r2 + c.k3 * r2 * r2 * r2;
  const double x_d = 0.2 * radial + 2 * c.p1 * 0.2 * -0.1 + c.p2 * (r2 + 2 * 0.04);
  const double y_d = -0.1 * radial + c.p1 * (r2 + 2 * 0.01) + 2 * c.p2 * 0.2 * -0.1;
  const Eigen::Vector2d x_px = *Project(c, {0.4, -0.2, 2.0});
  EXPECT_NEAR(x_px.x(), 1500 * x_d + 650, 1e-10);
  EXPECT_NEAR(x_px.y(), 1490 * y_d + 470, 1e-10);
  EXPECT_FALSE(Project(c, {0, 0, -1}));
  EXPECT_FALSE(Project(c, {0, 0, 0}));
}

TEST(Camera, JacobiansAgreeWithDifferences) {
  Camera c = DistortedCamera();
  c.skew_px = 0.7;
  const Eigen::Vector3d x_in_cam(0.31, -0.22, 1.3);
  const Projection projection = *ProjectWithJacobian(c, x_in_cam);
  EXPECT_LT((projection.x_px - *Project(c, x_in_cam)).norm(), 1e-12);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
    const Eigen::Vector2d slope = (*Project(c, x_in_cam + step) - *Project(c, x_in_cam - step)) / (2 * kStep);
    EXPECT_LT((slope - projection.by_point.col(k)).norm(), 1e-5) << "point coordinate " << k;
  }
  for (int k = 0; k < kNumIntrinsics; ++k) {
    Camera plus = c, minus = c;
    plus.SetIntrinsics(c.Intrinsics() + kStep * IntrinsicVector::Unit(k));
    minus.SetIntrinsics(c.Intrinsics() - kStep * IntrinsicVector::Unit(k));
    const Eigen::Vector2d slope = (*Project(plus, x_in_cam) - *Project(minus, x_in_cam)) / (2 * kStep);
    EXPECT_LT((slope - projection.by_intrinsics.col(k)).norm(), 1e-5) << kIntrinsicNames[k];
  }
}

TEST(Camera, RayIsTheInverseOfProjection) {
  const Camera c = DistortedCamera();
  for (double y = 0; y < 960; y += 80) {
    for (double x = 0; x < 1280; x += 80) {
      const auto ray = RayInCam(c, {x, y});
      ASSERT_TRUE(ray);
      EXPECT_LT((*Project(c, *ray * 3.0) - Eigen::Vector2d(x, y)).norm(), 1e-8);
    }
  }
}

TEST(Camera, NoRayBeyondTheFoldOfTheDistortion) {
  Camera c = DistortedCamera();
  c.k1 = -0.6, c.k2 = c.k3 = c.p1 = c.p2 = 0;  // x (1 - 0.6 r2) peaks at r = 0.745, at 0.497
  EXPECT_TRUE(RayInCam(c, {650 + 1500 * 0.45, 470}));
  EXPECT_FALSE(RayInCam(c, {650 + 1500 * 0.55, 470}));
}

TEST(Camera, LevelHalvesPixelsAboutTheCentreOfTheFirst) {
  Camera c = DistortedCamera();
  const Camera pinhole = Undistorted(c);
  const Rigid3d cam_from_world{ExpRotation({0.1, 0.2, 0.3}), {0.1, -0.2, 2.0}};
  const Eigen::Vector3d x_in_world(0.1, 0.2, 0.3);
  const Eigen::Vector2d at_0 = *Project(pinhole, cam_from_world * x_in_world);
  const Eigen::Vector3d q = ProjectionMatrix(pinhole, cam_from_world, 2) * x_in_world.homogeneous();
  EXPECT_LT((q.hnormalized() - at_0 / 4).norm(), 1e-12);
}

TEST(Rigid3d, NamesReadLikeTheArithmetic) {
  const Rigid3d b_from_a{ExpRotation({0, 0, 0.5}), {1, 2, 3}};
  const Rigid3d c_from_b{ExpRotation({0.3, 0, 0}), {-1, 0, 1}};
  const Eigen::Vector3d x_in_a(0.2, 0.4, 0.6);
  EXPECT_LT((c_from_b * (b_from_a * x_in_a) - (c_from_b * b_from_a) * x_in_a).norm(), 1e-14);
  EXPECT_LT((b_from_a.Inverse() * (b_from_a * x_in_a) - x_in_a).norm(), 1e-14);
  EXPECT_LT((b_from_a * CentreInWorld(b_from_a)).norm(), 1e-14);
  // A positive angle about +z turns +x towards +y.
  EXPECT_GT((ExpRotation({0, 0, 0.1}) * Eigen::Vector3d::UnitX()).y(), 0);
}

TEST(Rigid3d, LogInvertsExpAlsoNearZeroAndPi) {
  for (const double angle : {0.0, 1e-9, 1e-5, 0.5, 3.0, 3.1415}) {
    const Eigen::Vector3d w = angle * Eigen::Vector3d(1, -2, 3).normalized();
    EXPECT_LT((LogRotation(ExpRotation(w)) - w).norm(), 1e-9) << angle;
  }
}

TEST(Rigid3d, DisturbedTurnsAboutTheCamera) {
  const Rigid3d cam_from_world{ExpRotation({0.1, 0.2, 0.3}), {0.1, -0.2, 2.0}};
  Eigen::Matrix<double, 6, 1> delta;
  delta << 0.01, -0.02, 0.03, 0, 0, 0;
  EXPECT_LT((CentreInWorld(Disturbed(cam_from_world, delta)) - CentreInWorld(cam_from_world)).norm(), 1e-14);
  delta << 0, 0, 0, 0.1, 0, 0;
  const Eigen::Vector3d moved = Disturbed(cam_from_world, delta) * Eigen::Vector3d(1, 1, 1);
  EXPECT_LT((moved - (cam_from_world * Eigen::Vector3d(1, 1, 1) + Eigen::Vector3d(0.1, 0, 0))).norm(), 1e-14);
}

class TriangulationTest : public testing::Test {
 protected:
  TriangulationTest() {
    const Camera camera = Undistorted(DistortedCamera());
    for (const double angle : {-0.3, 0.0, 0.4}) {
      const Rigid3d cam_from_world{ExpRotation({0, angle, 0}), {0, 0, 1.0}};
      px_from_world_.push_back(ProjectionMatrix(camera, cam_from_world, 0));
    }
  }
  std::vector<Eigen::Matrix<double, 3, 4>> px_from_world_;
};

TEST_F(TriangulationTest, RecoversAPointFromNoisyPixels) {
  Random random(5);
  const Eigen::Vector3d truth(0.03, -0.02, 0.05);
  for (const double noise_px : {0.0, 0.3}) {
    std::vector<Eigen::Vector2d> x_px;
    for (const auto& p : px_from_world_) {
      x_px.emplace_back((p * truth.homogeneous()).hnormalized() +
                        noise_px * Eigen::Vector2d(random.Normal(), random.Normal()));
    }
    const auto x = TriangulateInWorld(px_from_world_, x_px);
    ASSERT_TRUE(x);
    EXPECT_LT((*x - truth).norm(), noise_px == 0 ? 1e-10 : 1.5e-3);  // 0.3 px at 1 m, f 1500: 0.2 mm across, ~1 mm deep
  }
}

TEST_F(TriangulationTest, NothingForParallelRays) {
  const std::vector<Eigen::Matrix<double, 3, 4>> twice(2, px_from_world_[0]);
  const std::vector<Eigen::Vector2d> x_px(2, Eigen::Vector2d(600, 400));
  EXPECT_FALSE(TriangulateInWorld(twice, x_px));
}

}  // namespace
}  // namespace rigcal
