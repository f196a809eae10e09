#pragma once

#include <opencv2/core.hpp>

namespace rigcal {

/// Grey value in [0, 1] from which a pixel counts as saturated: 250 of 255, and below full scale by more than the
/// compression of a JPEG changes it.
inline constexpr double kSaturatedGray = 0.98;

/// Share of saturated pixels above which a picture of a chart or an object is over-exposed: half of what is looked at
/// has no texture. Well exposed sets stay far below (at most 0.008 on templeSparseRing, squirrel and fountain-P11). A
/// white backdrop saturates on purpose, which is why only the pixels of the object count where a mask tells them.
inline constexpr double kMaxSaturatedShare = 0.5;

/// Share of the pixels that are saturated, among those of the object. `gray` in [0, 1]; `mask`: kMaskThreshold and
/// above is object, same size; empty: the whole picture. 0 when there is no object.
double SaturatedShare(const cv::Mat1f& gray, const cv::Mat1b& mask);

}  // namespace rigcal
