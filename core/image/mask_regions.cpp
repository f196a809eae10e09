#include "core/image/mask_regions.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace rigcal {
namespace {

constexpr double kSpeckShare = 0.005;  ///< of the largest region: gaps between the beads of a necklace are wider

/// Where the mask is set, and a pixel more on each side that the picture has: regions are searched for there alone.
cv::Rect BoxOfSet(const cv::Mat1b& mask) {
  const cv::Rect set = cv::boundingRect(mask);
  if (set.empty()) return {};
  return cv::Rect(set.tl() - cv::Point(1, 1), set.br() + cv::Point(1, 1)) & cv::Rect({0, 0}, mask.size());
}

}  // namespace

cv::Mat1b BorderOf(cv::Size size_px) {
  const int width = std::max(1, static_cast<int>(std::lround(kBorderShare * std::min(size_px.width, size_px.height))));
  cv::Mat1b border(size_px, 255);
  border(cv::Rect(width, width, size_px.width - 2 * width, size_px.height - 2 * width)) = 0;
  return border;
}

double SetShareOfBorder(const cv::Mat1b& mask) {
  const cv::Mat1b border = BorderOf(mask.size());
  cv::Mat1b both;
  cv::bitwise_and(mask, border, both);
  return cv::countNonZero(both) / static_cast<double>(cv::countNonZero(border));
}

cv::Mat1b WithoutSpecks(const cv::Mat1b& mask) {
  cv::Mat1b kept(mask.size(), static_cast<uchar>(0));
  const cv::Rect box = BoxOfSet(mask);
  if (box.empty()) return kept;
  cv::Mat1i labels, stats;
  cv::Mat1d centroids;
  const int count = cv::connectedComponentsWithStats(mask(box), labels, stats, centroids, 8, CV_32S);
  int largest = 0;
  for (int i = 1; i < count; ++i) largest = std::max(largest, stats(i, cv::CC_STAT_AREA));
  cv::Mat1b kept_in_box = kept(box);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const int label = labels(y, x);
      if (label > 0 && stats(label, cv::CC_STAT_AREA) >= kSpeckShare * largest) kept_in_box(y, x) = 255;
    }
  }
  return kept;
}

cv::Mat1b WithHolesFilled(const cv::Mat1b& mask, const std::function<bool(const Hole&)>& is_object) {
  cv::Mat1b filled = mask.clone();
  // An unset region reaches the edge of this box if and only if it reaches the edge of the picture.
  const cv::Rect around = BoxOfSet(mask);
  if (around.empty()) return filled;
  cv::Mat1b unset;
  cv::bitwise_not(mask(around), unset);
  cv::Mat1i labels, stats;
  cv::Mat1d centroids;
  const int count = cv::connectedComponentsWithStats(unset, labels, stats, centroids, 4, CV_32S);
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(stats(i, cv::CC_STAT_LEFT), stats(i, cv::CC_STAT_TOP), stats(i, cv::CC_STAT_WIDTH),
                       stats(i, cv::CC_STAT_HEIGHT));
    const bool reaches_edge = box.x == 0 || box.y == 0 || box.br().x == around.width || box.br().y == around.height;
    if (reaches_edge) continue;
    Hole hole{box + around.tl(), {}, stats(i, cv::CC_STAT_AREA)};
    cv::compare(labels(box), i, hole.region, cv::CMP_EQ);
    if (is_object(hole)) filled(hole.box).setTo(255, hole.region);
  }
  return filled;
}

}  // namespace rigcal
