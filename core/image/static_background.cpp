#include "core/image/static_background.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/image/mask_regions.h"
#include "core/image/pyramid.h"

namespace rigcal {
namespace {

/// Side of the box over which pictures are averaged before they are compared: an unchanged background then agrees to a
/// fraction of a grey level, while weak texture that moves does not.
constexpr int kBox_px = 5;
/// Noise (standard deviation, after averaging) above which a border is not static: five grey levels of 8 bit.
constexpr double kNoisiestBorder = 0.02;
/// The least noise that is reckoned with: rounding to 8 bit, averaged.
constexpr double kLeastNoise = 0.0005;
constexpr double kBandInSigma = 6;      ///< width of the band within which values of one pixel agree
constexpr double kChangeInSigma = 3;    ///< from which an averaged value has changed
constexpr double kStrongChange = 0.02;  ///< of a single pixel: five grey levels, above the noise of cameras in use
/// A region in which object and background agree by chance is smaller than this.
constexpr int kChance_px = 9;
constexpr double kMostChangedBorder = 0.25;  ///< share of the border that the object may cover
/// A hole up to this share of the object is filled whatever it shows.
constexpr double kSpotShare = 0.001;
/// Share of the pictures in which a gap must show background to be one; less is the object agreeing by chance.
constexpr double kLeastShown = 0.15;

/// Standard deviation of the noise on the border, from differences between pictures that follow each other: robust, so
/// that an object that reaches the border does no harm.
double NoiseOnBorder(const std::vector<cv::Mat1f>& pictures) {
  const cv::Mat1b border = BorderOf(pictures[0].size());
  std::vector<float> differences;
  for (std::size_t i = 1; i < pictures.size(); ++i) {
    for (int y = 0; y < border.rows; ++y) {
      for (int x = 0; x < border.cols; ++x) {
        if (border(y, x) != 0) differences.push_back(std::abs(pictures[i](y, x) - pictures[i - 1](y, x)));
      }
    }
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  constexpr double kSigmaPerMedian = 1.4826;  // of a normal distribution
  return kSigmaPerMedian * static_cast<double>(*middle) / std::sqrt(2.0);
}

/// What every pixel shows in most pictures.
cv::Mat1f UsualValue(const std::vector<cv::Mat1f>& pictures, double band) {
  const std::size_t count = pictures.size();
  cv::Mat1f usual(pictures[0].size());
  std::vector<float> values(count);
  for (int y = 0; y < usual.rows; ++y) {
    for (int x = 0; x < usual.cols; ++x) {
      for (std::size_t i = 0; i < count; ++i) values[i] = pictures[i](y, x);
      std::sort(values.begin(), values.end());
      std::size_t best_first = 0, best_size = 0, first = 0;
      for (std::size_t last = 0; last < count; ++last) {
        while (static_cast<double>(values[last] - values[first]) > band) ++first;
        if (last - first + 1 > best_size) best_size = last - first + 1, best_first = first;
      }
      usual(y, x) = values[best_first + best_size / 2];
    }
  }
  return usual;
}

/// The background of all pictures: what it looks like, and in which share of them it shows.
struct BackgroundModel {
  cv::Mat1f value, shown_share;
};

BackgroundModel ModelOf(const std::vector<cv::Mat1f>& pictures, const std::vector<cv::Mat1b>& unchanged) {
  cv::Mat1f sum(pictures[0].size(), 0.0f), count(pictures[0].size(), 0.0f);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    cv::add(sum, pictures[i], sum, unchanged[i]);
    cv::add(count, 1.0, count, unchanged[i]);
  }
  BackgroundModel model;
  cv::divide(sum, count, model.value);
  model.shown_share = count / static_cast<double>(pictures.size());
  return model;
}

/// Where the averaged picture agrees with what is usual, in regions too large for chance.
cv::Mat1b Unchanged(const cv::Mat1f& averaged, const cv::Mat1f& usual, double least_change) {
  cv::Mat1f change;
  cv::absdiff(averaged, usual, change);
  cv::Mat1b unchanged;
  cv::compare(change, least_change, unchanged, cv::CMP_LE);
  cv::medianBlur(unchanged, unchanged, 3);
  cv::morphologyEx(unchanged, unchanged, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(kChance_px, kChance_px)));
  return unchanged;
}

/// The object: what has changed, less the margin by which averaging widens it, but with all pixels that differ clearly
/// from a background that is known there.
cv::Mat1b ObjectIn(const cv::Mat1f& picture, const cv::Mat1b& unchanged, const BackgroundModel& model) {
  cv::Mat1b changed, inner, known, different;
  cv::bitwise_not(unchanged, changed);
  cv::erode(changed, inner, cv::getStructuringElement(cv::MORPH_RECT, cv::Size(kBox_px, kBox_px)));
  cv::Mat1f change;
  cv::absdiff(picture, model.value, change);
  cv::compare(change, kStrongChange, different, cv::CMP_GT);
  cv::compare(model.shown_share, 0, known, cv::CMP_GT);
  cv::bitwise_and(different, known, different);
  cv::bitwise_and(different, changed, different);
  cv::bitwise_or(inner, different, inner);
  cv::medianBlur(inner, inner, 3);
  return WithoutSpecks(inner);
}

/// Without holes but those through which the background shows.
cv::Mat1b WithSpotsFilled(const cv::Mat1b& object, const BackgroundModel& model) {
  const double spot_px = kSpotShare * cv::countNonZero(object);
  return WithHolesFilled(object, [&](const Hole& hole) {
    return hole.area_px <= spot_px || cv::mean(model.shown_share(hole.box), hole.region)[0] < kLeastShown;
  });
}

/// Pictures of size_px from one at level `level`: pixel x_0 is taken from x_0 / 2^level.
cv::Mat1b Enlarged(const cv::Mat1b& mask, int level, cv::Size size_px) {
  if (level == 0) return mask;
  cv::Mat1b large(size_px);
  const double scale = std::ldexp(1.0, -level);
  for (int y = 0; y < large.rows; ++y) {
    const int source_y = std::min(static_cast<int>(std::lround(y * scale)), mask.rows - 1);
    for (int x = 0; x < large.cols; ++x) {
      large(y, x) = mask(source_y, std::min(static_cast<int>(std::lround(x * scale)), mask.cols - 1));
    }
  }
  return large;
}

}  // namespace

std::vector<cv::Mat1b> MasksOnStatic(const std::vector<cv::Mat1f>& pictures, const Execution& execution) {
  const int count = static_cast<int>(pictures.size());
  if (count < kFewestPictures) return {};
  const cv::Size size_px = pictures[0].size();
  int level = 0;
  while (std::max(size_px.width, size_px.height) >> level > kLongestSide_px) ++level;
  for (const cv::Mat1f& picture : pictures) {
    if (picture.size() != size_px) return {};
  }
  std::vector<cv::Mat1f> small(pictures.size()), averaged(pictures.size());
  if (!ParallelFor(execution, count, [&](int i) {
        small[i] = BuildPyramid(pictures[i], level + 1)[level];
        cv::blur(small[i], averaged[i], cv::Size(kBox_px, kBox_px));
      })) {
    return {};
  }
  const double noise = std::max(NoiseOnBorder(averaged), kLeastNoise);
  if (noise > kNoisiestBorder) return {};
  const cv::Mat1f usual = UsualValue(averaged, kBandInSigma * noise);
  std::vector<cv::Mat1b> unchanged(pictures.size());
  if (!ParallelFor(execution, count,
                   [&](int i) { unchanged[i] = Unchanged(averaged[i], usual, kChangeInSigma * noise); })) {
    return {};
  }
  const BackgroundModel model = ModelOf(small, unchanged);
  std::vector<cv::Mat1b> masks(pictures.size());
  std::vector<double> on_border(pictures.size());
  if (!ParallelFor(execution, count, [&](int i) {
        const cv::Mat1b object = ObjectIn(small[i], unchanged[i], model);
        on_border[i] = SetShareOfBorder(object);
        masks[i] = Enlarged(WithSpotsFilled(object, model), level, size_px);
      })) {
    return {};
  }
  if (*std::max_element(on_border.begin(), on_border.end()) > kMostChangedBorder) return {};
  return masks;
}

}  // namespace rigcal
