#include "core/image/exposure.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(Exposure, ShareOfTheObjectsPixels) {
  cv::Mat1f gray(4, 10, 0.3F);
  gray.colRange(0, 3) = 1.0F;
  gray(3, 9) = 249.0F / 255;
  gray(2, 9) = 250.0F / 255;
  EXPECT_DOUBLE_EQ(SaturatedShare(gray, {}), 13.0 / 40);
  cv::Mat1b mask(4, 10, 127);
  mask.colRange(2, 6) = 128;
  EXPECT_DOUBLE_EQ(SaturatedShare(gray, mask), 0.25);
  EXPECT_EQ(SaturatedShare(gray, cv::Mat1b(4, 10, static_cast<unsigned char>(0))), 0);
}

}  // namespace
}  // namespace rigcal
