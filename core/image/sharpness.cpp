#include "core/image/sharpness.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"

namespace rigcal {
namespace {

cv::Mat1f Blurred(const cv::Mat1f& image, double sigma_px) {
  cv::Mat1f blurred;
  cv::GaussianBlur(image, blurred, cv::Size(0, 0), sigma_px, sigma_px, cv::BORDER_REFLECT);
  return blurred;
}

double BandEnergy(const cv::Mat1f& finer, const cv::Mat1f& coarser, const cv::Mat1b& inside) {
  cv::Mat1f band;
  cv::subtract(finer, coarser, band);
  return cv::mean(band.mul(band), inside)[0];
}

}  // namespace

double Sharpness(const cv::Mat1f& gray, const cv::Mat1b& mask) {
  constexpr double kFineSigmaPx = 1, kFineEndSigmaPx = 2, kCoarseSigmaPx = 4, kCoarseEndSigmaPx = 8;
  constexpr int kRimPx = 12;             // the coarse band sees the background up to here (1.5 sigmas)
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
  const double fine = BandEnergy(Blurred(gray, kFineSigmaPx), Blurred(gray, kFineEndSigmaPx), inside);
  const double coarse = BandEnergy(Blurred(gray, kCoarseSigmaPx), Blurred(gray, kCoarseEndSigmaPx), inside);
  if (!(coarse > kMinContrast * kMinContrast)) return 0;
  return std::sqrt(fine / coarse);
}

}  // namespace rigcal
