#pragma once

#include <cstring>
#include <opencv2/core.hpp>

namespace rigcal {

/// Whether two pictures have the same size, type and pixels.
inline bool SameBytes(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y) {
    if (std::memcmp(a.ptr(y), b.ptr(y), a.cols * a.elemSize()) != 0) return false;
  }
  return true;
}

}  // namespace rigcal
