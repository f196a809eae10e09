#pragma once

#include <functional>
#include <opencv2/core.hpp>

namespace rigcal {

/// Pixels within this share of the shorter side from the edge of a picture count as its border.
inline constexpr double kBorderShare = 0.02;

/// 255 on the border.
cv::Mat1b BorderOf(cv::Size size_px);

/// Share of the border's pixels that are set.
double SetShareOfBorder(const cv::Mat1b& mask);

/// Only the connected regions that are not small against the largest one (at least 0.5 % of its area).
cv::Mat1b WithoutSpecks(const cv::Mat1b& mask);

/// Fills the holes (unset regions that do not reach the edge of the picture) for which `is_object(region, area_px)` is
/// true; region is 255 in the hole.
cv::Mat1b WithHolesFilled(const cv::Mat1b& mask,
                          const std::function<bool(const cv::Mat1b& region, int area_px)>& is_object);

}  // namespace rigcal
