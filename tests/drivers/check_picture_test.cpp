#include "drivers/acquire/check_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "drivers/acquire/same_bytes.h"
#include "tests/drivers/scripted_devices.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

TEST(MeasurePicture, CountsSaturatedPixelsOfAnyChannelAndDepth) {
  cv::Mat gray(20, 10, CV_8U, cv::Scalar(100));
  gray.rowRange(0, 3).setTo(255);
  gray.row(3).setTo(249);
  EXPECT_NEAR(MeasurePicture(gray).saturated, 0.15, 1e-12);
  cv::Mat wide(20, 10, CV_16U, cv::Scalar(100 * 257));
  wide.rowRange(0, 3).setTo(65520);  // 12 bits at full scale
  EXPECT_NEAR(MeasurePicture(wide).saturated, 0.15, 1e-12);
  cv::Mat colour(20, 10, CV_8UC3, cv::Scalar(10, 20, 30));
  colour.rowRange(0, 5).setTo(cv::Scalar(10, 20, 255));
  EXPECT_NEAR(MeasurePicture(colour).saturated, 0.25, 1e-12);
}

TEST(MeasurePicture, BrightnessIsThatOfTheBrightestHundredth) {
  cv::Mat gray(20, 50, CV_8U, cv::Scalar(0));
  gray.row(0).colRange(0, 5).setTo(51);
  EXPECT_NEAR(MeasurePicture(gray).brightness, 0.1, 1e-12);  // 5 of 10 pixels at 0.2
}

TEST(MeasurePicture, BlurTakesSharpnessAwayAndContrastDoesNot) {
  const cv::Mat picture = TexturedPicture(1);
  cv::Mat blurred, faint;
  cv::GaussianBlur(picture, blurred, cv::Size(), 4);
  picture.convertTo(faint, CV_8U, 0.5, 60);
  const double sharpness = MeasurePicture(picture).sharpness;
  EXPECT_LT(MeasurePicture(blurred).sharpness, 0.2 * sharpness);
  EXPECT_NEAR(MeasurePicture(faint).sharpness, sharpness, 0.05 * sharpness);
  EXPECT_EQ(MeasurePicture(cv::Mat(8, 8, CV_8U, cv::Scalar(7))).sharpness, 0);
}

TEST(SameBytes, OfOneSizeAndTypeOnly) {
  const cv::Mat picture = TexturedPicture(1);
  EXPECT_TRUE(SameBytes(picture, picture.clone()));
  EXPECT_TRUE(SameBytes(picture.colRange(0, 10), picture.colRange(0, 10).clone())) << "rows of a part are not together";
  cv::Mat other = picture.clone();
  other.at<std::uint8_t>(other.rows - 1, other.cols - 1) ^= 1;
  EXPECT_FALSE(SameBytes(picture, other));
  EXPECT_FALSE(SameBytes(picture, picture.rowRange(0, 10)));
  EXPECT_FALSE(SameBytes(picture, cv::Mat(picture.size(), CV_16U, cv::Scalar(0))));
}

TEST(PictureCheck, JudgesAgainstTheLastGoodOne) {
  PictureCheck check(CaptureSettings{});
  cv::Mat blurred;
  cv::GaussianBlur(TexturedPicture(2), blurred, cv::Size(), 4);
  EXPECT_FALSE(check.Judge(TexturedPicture(1)));
  EXPECT_THAT(check.Judge(blurred).value_or("good"), HasSubstr("blurred"));
  EXPECT_THAT(check.Judge(blurred).value_or("good"), HasSubstr("limit 0.30")) << "a bad one is not what counts";
  EXPECT_FALSE(check.Judge(TexturedPicture(2)));
  EXPECT_THAT(check.Judge(TexturedPicture(2)).value_or("good"), HasSubstr("byte for byte"));
  EXPECT_THAT(check.Judge(cv::Mat(48, 64, CV_8U, cv::Scalar(1))).value_or("good"), HasSubstr("dark"));
}

TEST(PictureCheck, ChecksThatAreTurnedOffFindNothing) {
  PictureCheck check({.max_saturated = 1, .min_brightness = 0, .min_sharpness = 0, .refuse_identical = false});
  EXPECT_FALSE(check.Judge(TexturedPicture(1)));
  EXPECT_FALSE(check.Judge(TexturedPicture(1)));
  EXPECT_FALSE(check.Judge(cv::Mat(48, 64, CV_8U, cv::Scalar(0))));
  EXPECT_FALSE(check.Judge(cv::Mat(48, 64, CV_8U, cv::Scalar(255))));
}

}  // namespace
}  // namespace rigcal
