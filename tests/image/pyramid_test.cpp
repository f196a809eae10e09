#include "core/image/pyramid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/image/sample.h"
#include "core/image/undistort.h"

namespace rigcal {
namespace {

cv::Mat1f Blob(cv::Size size, Eigen::Vector2d centre_px, double sigma_px) {
  cv::Mat1f image(size);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double r2 = (Eigen::Vector2d(x, y) - centre_px).squaredNorm();
      image(y, x) = static_cast<float>(std::exp(-0.5 * r2 / (sigma_px * sigma_px)));
    }
  }
  return image;
}

Eigen::Vector2d Centroid(const cv::Mat1f& image) {
  const cv::Moments m = cv::moments(image);
  return {m.m10 / m.m00, m.m01 / m.m00};
}

// cv::resize instead of pyrDown would put the blob 0.25 level pixels off at level 1 and 0.44 at level 3.
TEST(Pyramid, LevelsDivideCoordinatesByPowersOfTwo) {
  const Eigen::Vector2d centre_px(150.3, 131.8);
  const Pyramid pyramid = BuildPyramid(Blob({320, 256}, centre_px, 12.0), 4);
  ASSERT_EQ(pyramid.size(), 4u);
  for (int level = 0; level < 4; ++level) {
    EXPECT_LT((Centroid(pyramid[level]) - centre_px / std::pow(2.0, level)).norm(), 2e-3) << "level " << level;
  }
}

TEST(Sample, CubicHasItsOwnGradientAndNoShift) {
  const Eigen::Vector2d centre_px(20.3, 19.6);
  const cv::Mat1f image = Blob({40, 40}, centre_px, 3.0);
  for (const auto& [x, y] : {std::pair(18.2f, 21.7f), std::pair(22.9f, 17.1f)}) {
    const SampleWithGradient s = SampleCubic(image, x, y);
    const double truth = std::exp(-0.5 * (Eigen::Vector2d(x, y) - centre_px).squaredNorm() / 9.0);
    EXPECT_NEAR(s.value, truth, 2e-3);
    constexpr float kStep = 0.01f;
    EXPECT_NEAR(s.by_x, (SampleCubic(image, x + kStep, y).value - SampleCubic(image, x - kStep, y).value) / 0.02, 1e-3);
    EXPECT_NEAR(s.by_y, (SampleCubic(image, x, y + kStep).value - SampleCubic(image, x, y - kStep).value) / 0.02, 1e-3);
    EXPECT_NEAR(SampleBilinear(image, x, y), truth, 1e-2);
  }
  EXPECT_FLOAT_EQ(SampleCubic(image, 20, 19).value, image(19, 20));
  EXPECT_TRUE(CanSample(image, 1, 1, 1));
  EXPECT_FALSE(CanSample(image, 0.99, 1, 1));
  EXPECT_FALSE(CanSample(image, 38, 20, 1));
}

TEST(Undistort, MovesAPictureToWhereThePinholeSeesIt) {
  Camera camera;
  camera.width_px = 320, camera.height_px = 256;
  camera.fx_px = camera.fy_px = 300, camera.cx_px = 159.5, camera.cy_px = 127.5;
  camera.k1 = -0.2, camera.p1 = 0.002;
  const Eigen::Vector3d x_in_cam(0.35, 0.25, 1.0);
  const cv::Mat1f picture = Blob({320, 256}, *Project(camera, x_in_cam), 4.0);
  const Eigen::Vector2d expected_px = *Project(Undistorted(camera), x_in_cam);
  // The local magnification is not constant over the blob: a few hundredths of a pixel.
  EXPECT_LT((Centroid(Undistort(picture, camera)) - expected_px).norm(), 0.1);
  EXPECT_LT((OriginalFromUndistorted(camera, expected_px) - *Project(camera, x_in_cam)).norm(), 1e-9);
  EXPECT_GT((expected_px - *Project(camera, x_in_cam)).norm(), 3.0);
}

}  // namespace
}  // namespace rigcal
