#include "drivers/acquire/check_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/image/exposure.h"
#include "drivers/acquire/same_bytes.h"

namespace rigcal {
namespace {

constexpr double kBrightestShare = 0.01;
constexpr int kLevels = 256;

/// One channel of 8 bits.
cv::Mat1b Brightest(const cv::Mat& pixels) {
  cv::Mat bytes = pixels;
  if (pixels.depth() == CV_16U) pixels.convertTo(bytes, CV_8U, 255.0 / 65535);
  if (bytes.channels() == 1) return bytes;
  std::vector<cv::Mat> channels;
  cv::split(bytes, channels);
  for (std::size_t c = 1; c < channels.size(); ++c) cv::max(channels[0], channels[c], channels[0]);
  return channels[0];
}

std::array<double, kLevels> HistogramOf(const cv::Mat1b& gray) {
  std::array<double, kLevels> counts{};
  for (int y = 0; y < gray.rows; ++y) {
    const std::uint8_t* row = gray[y];
    for (int x = 0; x < gray.cols; ++x) counts[row[x]] += 1;
  }
  return counts;
}

double MeanOfBrightest(const std::array<double, kLevels>& counts, double num_pixels) {
  const double wanted = std::max(1.0, kBrightestShare * num_pixels);
  double sum = 0, left = wanted;
  for (int level = kLevels - 1; level >= 0 && left > 0; --level) {
    const double taken = std::min(left, counts[level]);
    sum += taken * level;
    left -= taken;
  }
  return sum / wanted / (kLevels - 1);
}

double SharpnessOf(const cv::Mat1b& gray) {
  cv::Mat half, laplacian;
  cv::pyrDown(gray, half);
  cv::Scalar mean, sigma;
  cv::meanStdDev(half, mean, sigma);
  if (sigma[0] <= 0) return 0;
  cv::Laplacian(half, laplacian, CV_16S);
  const double square_sum = std::pow(cv::norm(laplacian, cv::NORM_L2), 2);
  return square_sum / static_cast<double>(half.total()) / (sigma[0] * sigma[0]);
}

}  // namespace

PictureQuality MeasurePicture(const cv::Mat& pixels) {
  const cv::Mat1b gray = Brightest(pixels);
  const std::array<double, kLevels> counts = HistogramOf(gray);
  const double num_pixels = static_cast<double>(gray.total());
  PictureQuality quality{.brightness = MeanOfBrightest(counts, num_pixels), .sharpness = SharpnessOf(gray)};
  const int first_saturated = static_cast<int>(std::ceil(kSaturatedGray * (kLevels - 1)));
  for (int level = first_saturated; level < kLevels; ++level) quality.saturated += counts[level] / num_pixels;
  return quality;
}

std::optional<std::string> PictureCheck::Judge(const cv::Mat& pixels) {
  if (settings_.refuse_identical && SameBytes(pixels, last_good_)) {
    return "the picture is the last one again, byte for byte";
  }
  const PictureQuality quality = MeasurePicture(pixels);
  if (quality.saturated > settings_.max_saturated) {
    return fmt::format("{:.0f} % of the pixels are saturated (limit {:.0f} %)", 100 * quality.saturated,
                       100 * settings_.max_saturated);
  }
  if (quality.brightness < settings_.min_brightness) {
    return fmt::format("the picture is dark: its brightest hundredth has {:.4f} of full scale (limit {:.4f})",
                       quality.brightness, settings_.min_brightness);
  }
  if (quality.sharpness < settings_.min_sharpness * last_sharpness_) {
    return fmt::format("the picture is blurred: its sharpness is {:.2f} of the last good one's (limit {:.2f})",
                       quality.sharpness / last_sharpness_, settings_.min_sharpness);
  }
  last_good_ = pixels;
  last_sharpness_ = quality.sharpness;
  return std::nullopt;
}

}  // namespace rigcal
