#pragma once

#include <cmath>
#include <opencv2/core.hpp>

namespace rigcal {

/// A grey value proportional to light, in [0, 1], as sRGB encodes it (IEC 61966-2-1: a straight piece near black, then
/// a power of 2.4), and back. Also for Ceres' jets.
template <typename T>
T SrgbEncoded(const T& light) {
  using std::pow;
  return light <= 0.0031308 ? T(12.92 * light) : T(1.055 * pow(light, 1 / 2.4) - 0.055);
}
inline double SrgbDecoded(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// A whole picture; values are clipped to [0, 1].
cv::Mat1f SrgbEncodedPicture(const cv::Mat1f& light);

/// In [0, 255], rounded.
cv::Mat1b EightBits(const cv::Mat1f& picture);

}  // namespace rigcal
