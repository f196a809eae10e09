#include "core/image/dark_background.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/image/mask_regions.h"

namespace rigcal {
namespace {

constexpr int kBins = 64;  ///< of four grey levels of 8 bit: wider than the noise of a cloth
/// A cloth is darker than this on average, the object at least kContrast times as bright (measured: cloth 0.01 to 0.05,
/// object 0.4 to 0.7).
constexpr double kDarkestObject = 0.15, kContrast = 3;
/// The valley between cloth and object against the cloth's highest bin (measured: 0.0002 to 0.011).
constexpr double kDeepestValley = 0.1;
/// Where the histogram has come down to this many times the valley, the cloth ends and dark parts of the object begin.
constexpr double kFoot = 2;
constexpr double kEmptyBin = 0.0005;  ///< share of pixels in a bin that counts as none
/// Share of the border that must be below the threshold: over all pictures, and in each (the object may be cut off).
constexpr double kDarkBorder = 0.85, kDarkBorderOfEach = 0.6;
constexpr double kSmoothing_px = 1.0;  ///< Gaussian sigma before the threshold: noise does not make specks
/// A dark hole up to this share of the object is a dark spot on it; larger ones are gaps that show the cloth.
constexpr double kSpotShare = 0.001;

using Histogram = std::array<double, kBins>;

/// Pixels of each bin; bin i holds values in [i, i + 1) / kBins. Neighbours are counted apart: they mostly fall into
/// the same bin, and would wait for each other there.
std::array<int, kBins> CountOf(const cv::Mat1f& picture) {
  std::array<std::array<int, kBins>, 4> counts{};
  for (int y = 0; y < picture.rows; ++y) {
    const float* const row = picture[y];
    for (int x = 0; x < picture.cols; ++x) ++counts[x % 4][std::clamp(static_cast<int>(row[x] * kBins), 0, kBins - 1)];
  }
  for (int bin = 0; bin < kBins; ++bin) counts[0][bin] += counts[1][bin] + counts[2][bin] + counts[3][bin];
  return counts[0];
}

/// Shares of the pixels of all pictures; nothing when it was stopped.
std::optional<Histogram> HistogramOf(const std::vector<cv::Mat1f>& pictures, const Execution& execution) {
  std::vector<std::array<int, kBins>> counts(pictures.size());
  const bool finished =
      ParallelFor(execution, static_cast<int>(pictures.size()), [&](int i) { counts[i] = CountOf(pictures[i]); });
  if (!finished) return std::nullopt;
  Histogram shares{};
  double total = 0;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (int bin = 0; bin < kBins; ++bin) shares[bin] += counts[i][bin];
    total += static_cast<double>(pictures[i].total());
  }
  for (double& share : shares) share /= total;
  return shares;
}

struct TwoClasses {
  int first_bright = 0;  ///< bin
  double dark_mean = 0, bright_mean = 0;
};

/// Otsu's split.
TwoClasses Split(const Histogram& histogram) {
  TwoClasses best;
  double best_between = -1;
  double weight = 0, moment = 0, total_moment = 0;
  for (int i = 0; i < kBins; ++i) total_moment += histogram[i] * (i + 0.5) / kBins;
  for (int i = 0; i + 1 < kBins; ++i) {
    weight += histogram[i];
    moment += histogram[i] * (i + 0.5) / kBins;
    if (weight <= 0 || weight >= 1) continue;
    const double dark = moment / weight, bright = (total_moment - moment) / (1 - weight);
    const double between = weight * (1 - weight) * (bright - dark) * (bright - dark);
    if (between > best_between) {
      best_between = between;
      best = {i + 1, dark, bright};
    }
  }
  return best;
}

std::optional<double> Threshold(const Histogram& histogram) {
  const TwoClasses classes = Split(histogram);
  if (classes.dark_mean > kDarkestObject || classes.bright_mean < kContrast * classes.dark_mean) return std::nullopt;
  const auto dark_end = histogram.begin() + classes.first_bright;
  const auto peak = std::max_element(histogram.begin(), dark_end);
  const auto valley = std::min_element(peak, std::min(dark_end + 1, histogram.end()));
  if (*valley > kDeepestValley * *peak) return std::nullopt;
  // The last bin of the cloth is the last one before the valley that is clearly fuller than the valley.
  const double foot = std::max(kFoot * *valley, kEmptyBin);
  auto bin = valley;
  while (bin != peak && *(bin - 1) <= foot) --bin;
  return static_cast<double>(bin - histogram.begin()) / kBins;
}

struct DarkMask {
  cv::Mat1b object;
  double bright_border = 0;  ///< share of the border that is not dark
};

DarkMask MaskOf(const cv::Mat1f& picture, double threshold) {
  cv::Mat1f smooth;
  cv::GaussianBlur(picture, smooth, cv::Size(), kSmoothing_px);
  cv::Mat1b bright;
  cv::compare(smooth, threshold, bright, cv::CMP_GE);
  // Smoothing and a threshold at the foot of the cloth's peak put the outline a pixel too far out (measured).
  cv::erode(bright, bright, cv::getStructuringElement(cv::MORPH_CROSS, cv::Size(3, 3)));
  bright = WithoutSpecks(bright);
  const double spot_px = kSpotShare * cv::countNonZero(bright);
  return {WithHolesFilled(bright, [&](const Hole& hole) { return hole.area_px <= spot_px; }), SetShareOfBorder(bright)};
}

}  // namespace

std::vector<cv::Mat1b> MasksOnDark(const std::vector<cv::Mat1f>& pictures, const Execution& execution) {
  if (pictures.empty()) return {};
  const std::optional<Histogram> histogram = HistogramOf(pictures, execution);
  if (!histogram) return {};
  const auto threshold = Threshold(*histogram);
  if (!threshold) return {};
  std::vector<DarkMask> found(pictures.size());
  const bool finished = ParallelFor(execution, static_cast<int>(pictures.size()),
                                    [&](int i) { found[i] = MaskOf(pictures[i], *threshold); });
  if (!finished) return {};
  std::vector<cv::Mat1b> masks;
  double bright_border = 0;
  for (const DarkMask& mask : found) {
    if (mask.bright_border > 1 - kDarkBorderOfEach) return {};
    bright_border += mask.bright_border / static_cast<double>(pictures.size());
    masks.push_back(mask.object);
  }
  if (bright_border > 1 - kDarkBorder) return {};
  return masks;
}

}  // namespace rigcal
