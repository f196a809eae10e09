#include "core/image/sharpness.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

cv::Mat1f Smoothed(const cv::Mat1f& image, double sigma_px) {
  cv::Mat1f smoothed;
  cv::GaussianBlur(image, smoothed, cv::Size(0, 0), sigma_px, sigma_px, cv::BORDER_REFLECT);
  return smoothed;
}

/// Smoothed over the pixels of weight 1 alone: nothing of the background comes in. Meaningful where the weight is 1.
cv::Mat1f SmoothedInside(const cv::Mat1f& image, const cv::Mat1f& weight, double sigma_px) {
  cv::Mat1f weighted, smoothed;
  cv::multiply(image, weight, weighted);
  cv::divide(Smoothed(weighted, sigma_px), Smoothed(weight, sigma_px), smoothed);
  return smoothed;
}

double BandEnergy(const cv::Mat1f& finer, const cv::Mat1f& coarser, const cv::Mat1b& inside) {
  cv::Mat1f band;
  cv::subtract(finer, coarser, band);
  return cv::mean(band.mul(band), inside)[0];
}

}  // namespace

double Sharpness(const cv::Mat1f& gray, const cv::Mat1b& mask) {
  constexpr double kFineSigmaPx = 1, kFineEndSigmaPx = 2, kCoarseSigmaPx = 4, kCoarseEndSigmaPx = 8;
  constexpr int kRimPx = 3;              // pixels that mix object and background, and a mask that is not exact
  constexpr int kMinPixels = 1000;       // below, a few spots decide
  constexpr double kMinContrast = 1e-3;  // a quarter of a grey value of 255: no texture but noise
  Ensure(mask.empty() || mask.size() == gray.size(), "a mask has the size of its picture");
  if (gray.empty()) return 0;
  cv::Mat1b inside(gray.size(), 255);
  if (!mask.empty()) {
    const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * kRimPx + 1, 2 * kRimPx + 1));
    cv::erode(mask >= 128, inside, disc, cv::Point(-1, -1), 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    if (cv::countNonZero(inside) < kMinPixels) return 0;
  }
  cv::Mat1f weight;
  inside.convertTo(weight, CV_32F, 1.0 / 255);
  const auto smoothed = [&](double sigma_px) { return SmoothedInside(gray, weight, sigma_px); };
  const double fine = BandEnergy(smoothed(kFineSigmaPx), smoothed(kFineEndSigmaPx), inside);
  const double coarse = BandEnergy(smoothed(kCoarseSigmaPx), smoothed(kCoarseEndSigmaPx), inside);
  if (!(coarse > kMinContrast * kMinContrast)) return 0;
  return std::sqrt(fine / coarse);
}

}  // namespace rigcal
