#pragma once

#include <functional>
#include <opencv2/core.hpp>

namespace rigcal {

inline constexpr int kMaskThreshold = 128;  ///< grey value from which a mask pixel is object (docs/formats.md)

/// Pixels within this share of the shorter side from the edge of a picture count as its border.
inline constexpr double kBorderShare = 0.02;

/// 255 on the border.
cv::Mat1b BorderOf(cv::Size size_px);

/// Share of the border's pixels that are set.
double SetShareOfBorder(const cv::Mat1b& mask);

/// Only the connected regions that are not small against the largest one (at least 0.5 % of its area).
cv::Mat1b WithoutSpecks(const cv::Mat1b& mask);

/// An unset region of a mask that does not reach the edge of the picture.
struct Hole {
  cv::Rect box;      ///< in the picture
  cv::Mat1b region;  ///< of the box's size, 255 in the hole
  int area_px = 0;
};

/// Fills the holes for which is_object is true.
cv::Mat1b WithHolesFilled(const cv::Mat1b& mask, const std::function<bool(const Hole&)>& is_object);

}  // namespace rigcal
