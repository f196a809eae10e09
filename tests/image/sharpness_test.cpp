#include "core/image/sharpness.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "core/base/random.h"

namespace rigcal {
namespace {

/// Noise with detail at all scales, 0.5 +- contrast, in a disc on black.
cv::Mat1f TexturedDisc(double contrast, cv::Mat1b* mask) {
  Random random(3);
  cv::Mat1f noise(200, 200), coarse, picture(200, 200, 0.0F);
  for (float& v : noise) v = static_cast<float>(random.Normal());
  cv::GaussianBlur(noise, coarse, cv::Size(0, 0), 4);
  cv::GaussianBlur(noise, noise, cv::Size(0, 0), 1);
  *mask = cv::Mat1b(200, 200, uchar{0});
  cv::circle(*mask, {100, 100}, 70, cv::Scalar(255), cv::FILLED);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      if ((*mask)(y, x) > 0) picture(y, x) = 0.5F + static_cast<float>(contrast) * (noise(y, x) + 4 * coarse(y, x));
    }
  }
  return picture;
}

TEST(Sharpness, FallsWithBlur) {
  cv::Mat1b mask;
  const cv::Mat1f sharp = TexturedDisc(0.05, &mask);
  cv::Mat1f blurred;
  cv::GaussianBlur(sharp, blurred, cv::Size(0, 0), 2);
  EXPECT_LT(Sharpness(blurred, mask), 0.6 * Sharpness(sharp, mask));
  EXPECT_GT(Sharpness(blurred, mask), 0);
}

TEST(Sharpness, DoesNotDependOnContrastOrOnTheRim) {
  cv::Mat1b mask;
  const double strong = Sharpness(TexturedDisc(0.05, &mask), mask);
  EXPECT_NEAR(Sharpness(TexturedDisc(0.01, &mask), mask), strong, 0.1 * strong);
}

TEST(Sharpness, IsZeroWithoutObjectOrContrast) {
  EXPECT_EQ(Sharpness(cv::Mat1f(100, 100, 0.0F), {}), 0);
  EXPECT_EQ(Sharpness(cv::Mat1f(100, 100, 0.5F), cv::Mat1b(100, 100, uchar{0})), 0);
}

}  // namespace
}  // namespace rigcal
