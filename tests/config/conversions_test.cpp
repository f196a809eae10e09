#include "config/formats/conversions.h"

#include <gtest/gtest.h>

#include "core/geometry/rigid3.h"

namespace rigcal {
namespace {

Camera Upright() {
  Camera camera;
  camera.width_px = 100, camera.height_px = 201;
  camera.cx_px = 49.5, camera.cy_px = 100;  // the middle: half way between pixels 49 and 50, and on pixel 100
  return camera;
}

TEST(Conversions, TheFirstPixelsCentreIsHalfAPixelFromItsCorner) {
  Camera camera = Upright();
  camera.cx_px = 0, camera.cy_px = 3;
  EXPECT_EQ(PrincipalPointFromCornerPx(camera), Eigen::Vector2d(0.5, 3.5));
}

TEST(Conversions, TheMiddleOfAPicture) {
  Camera camera = Upright();
  EXPECT_EQ(MiddlePx(camera), Eigen::Vector2d(49.5, 100));
  EXPECT_EQ(PrincipalPointFromMiddlePx(camera), Eigen::Vector2d(0, 0));
  camera.cx_px += 1, camera.cy_px -= 2;  // right and up
  EXPECT_EQ(PrincipalPointFromMiddlePx(camera), Eigen::Vector2d(1, -2));
}

TEST(Conversions, OpenGlLooksBackwardAndHasItsYUp) {
  const Rigid3d cam_from_world{ExpRotation({0.3, -0.2, 0.1}), {0.1, 0.2, 0.3}};
  const Eigen::Vector3d x_in_world(1, 2, 3), x_in_cam = cam_from_world * x_in_world;
  const Eigen::Vector3d x_in_gl_cam = GlCamFromWorld(cam_from_world) * x_in_world;
  EXPECT_LT((x_in_gl_cam - Eigen::Vector3d(x_in_cam.x(), -x_in_cam.y(), -x_in_cam.z())).norm(), 1e-15);
  EXPECT_LT((CentreInWorld(GlCamFromWorld(cam_from_world)) - CentreInWorld(cam_from_world)).norm(), 1e-15);
}

TEST(Conversions, AMatrixMovesPointsAsThePoseDoes) {
  const Rigid3d b_from_a{ExpRotation({0.3, -0.2, 0.1}), {0.1, 0.2, 0.3}};
  const Eigen::Vector3d x_in_a(1, 2, 3);
  EXPECT_LT(((MatrixOf(b_from_a) * x_in_a.homogeneous()).hnormalized() - b_from_a * x_in_a).norm(), 1e-15);
  EXPECT_EQ(MatrixOf(b_from_a).row(3), Eigen::RowVector4d(0, 0, 0, 1));
}

}  // namespace
}  // namespace rigcal
