#include "core/seed/gamma.h"

#include <algorithm>

namespace rigcal {

cv::Mat1f SrgbEncodedPicture(const cv::Mat1f& light) {
  cv::Mat1f encoded(light.size());
  std::transform(light.begin(), light.end(), encoded.begin(), [](float value) {
    return static_cast<float>(SrgbEncoded(std::clamp(static_cast<double>(value), 0.0, 1.0)));
  });
  return encoded;
}

cv::Mat1b EightBits(const cv::Mat1f& picture) {
  cv::Mat1b bits;
  picture.convertTo(bits, CV_8U, 255);
  return bits;
}

}  // namespace rigcal
