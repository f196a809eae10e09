#include "config/decode_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/base/random.h"

namespace rigcal {
namespace {

using ::testing::HasSubstr;

/// Noise, so that no coder makes it small.
cv::Mat Picture(int type) {
  cv::Mat picture(48, 64, type);
  cv::RNG random(1);
  random.fill(picture, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return picture;
}

std::string Encoded(const std::string& extension, const cv::Mat& picture, const std::vector<int>& parameters = {}) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, picture, bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

TEST(DecodeImage, KeepsDepthAndChannels) {
  for (int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3}) {
    const cv::Mat picture = Picture(type);
    const auto decoded = DecodeImage(Encoded(".png", picture), "a.png");
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(decoded->type(), type);
    EXPECT_EQ(cv::norm(*decoded, picture, cv::NORM_INF), 0);
  }
}

TEST(DecodeImage, GrayAndColour) {
  EXPECT_FLOAT_EQ(GrayOf(cv::Mat(2, 2, CV_8UC1, cv::Scalar(51)))(0, 0), 0.2F);
  EXPECT_FLOAT_EQ(GrayOf(cv::Mat(2, 2, CV_16UC1, cv::Scalar(13107)))(1, 1), 0.2F);
  EXPECT_NEAR(GrayOf(cv::Mat(2, 2, CV_8UC3, cv::Scalar(255, 0, 0)))(0, 0), 0.114, 1e-6);  // blue comes first
  EXPECT_EQ(ColourOf(Picture(CV_16UC3), 2).size(), cv::Size(16, 12));
  EXPECT_EQ(ColourOf(cv::Mat(8, 8, CV_16UC1, cv::Scalar(65535)), 0)(3, 3), cv::Vec3b(255, 255, 255));
}

class TruncatedImage : public ::testing::TestWithParam<std::string> {};

TEST_P(TruncatedImage, IsRefusedAtAnyLength) {
  const std::string whole = Encoded(GetParam(), Picture(CV_8UC3));
  ASSERT_TRUE(DecodeImage(whole, "whole"));
  for (std::size_t length = 0; length + 1 < whole.size(); length += 1 + whole.size() / 97) {
    const auto decoded = DecodeImage(whole.substr(0, length), "cut");
    ASSERT_FALSE(decoded) << GetParam() << " of " << length << " bytes instead of " << whole.size();
    EXPECT_EQ(decoded.error().code, ErrorCode::kBadInput);
    EXPECT_THAT(decoded.error().message, HasSubstr("cut: "));
  }
  EXPECT_FALSE(DecodeImage(whole.substr(0, whole.size() - 1), "cut by one byte"));
}

INSTANTIATE_TEST_SUITE_P(Formats, TruncatedImage, ::testing::Values(".png", ".jpg", ".ppm", ".bmp", ".tif"));

TEST(DecodeImage, ProgressiveAndRestartedJpegsAreComplete) {
  for (const std::vector<int>& parameters :
       {std::vector<int>{cv::IMWRITE_JPEG_PROGRESSIVE, 1}, {cv::IMWRITE_JPEG_RST_INTERVAL, 2}}) {
    const std::string whole = Encoded(".jpg", Picture(CV_8UC3), parameters);
    EXPECT_TRUE(DecodeImage(whole, "whole"));
    EXPECT_TRUE(DecodeImage(whole + "bytes that a camera puts behind the image", "longer"));
    EXPECT_FALSE(DecodeImage(whole.substr(0, whole.size() / 2), "half"));
  }
}

TEST(DecodeImage, PreviewDoesNotHideATruncatedJpeg) {
  // An application segment that holds a whole small JPEG, as EXIF does.
  const std::string preview = Encoded(".jpg", Picture(CV_8UC1)), whole = Encoded(".jpg", Picture(CV_8UC3));
  const std::size_t length = preview.size() + 2;
  const std::string segment =
      std::string("\xff\xe5") + static_cast<char>(length >> 8) + static_cast<char>(length) + preview;
  const std::string with_preview = whole.substr(0, 2) + segment + whole.substr(2);
  EXPECT_TRUE(DecodeImage(with_preview, "whole"));
  EXPECT_FALSE(DecodeImage(with_preview.substr(0, with_preview.size() - 100), "cut"));
}

TEST(DecodeImage, GarbageIsRefusedOrDecoded) {
  constexpr int kMutations = 100;
  Random random(5);
  for (const char* extension : {".png", ".jpg", ".ppm"}) {
    const std::string whole = Encoded(extension, Picture(CV_8UC3));
    for (int i = 0; i < kMutations; ++i) {
      std::string mutated = whole;
      for (int change = 0; change < 3; ++change)
        mutated[random.Index(mutated.size())] = static_cast<char>(random.Index(256));
      const auto decoded = DecodeImage(mutated, "mutated");
      EXPECT_TRUE(!decoded || !decoded->empty());
    }
  }
}

TEST(DecodeImage, RefusesWhatIsNoPicture) {
  EXPECT_FALSE(DecodeImage("", "empty"));
  EXPECT_FALSE(DecodeImage("a text", "text"));
  const auto floating = DecodeImage(Encoded(".tif", cv::Mat(4, 4, CV_32FC1, cv::Scalar(0.5))), "float.tif");
  ASSERT_FALSE(floating);
  EXPECT_THAT(floating.error().message, HasSubstr("8 or 16 bits"));
}

}  // namespace
}  // namespace rigcal
