#include "core/image/exposure.h"

#include "core/base/ensure.h"
#include "core/image/mask_regions.h"

namespace rigcal {

double SaturatedShare(const cv::Mat1f& gray, const cv::Mat1b& mask) {
  Ensure(mask.empty() || mask.size() == gray.size(), "a mask has the size of its picture");
  cv::Mat saturated = gray >= kSaturatedGray, object(gray.size(), CV_8U, cv::Scalar(255));
  if (!mask.empty()) object = mask >= kMaskThreshold;
  const int num_object = gray.empty() ? 0 : cv::countNonZero(object);
  if (num_object == 0) return 0;
  cv::bitwise_and(saturated, object, saturated);
  return static_cast<double>(cv::countNonZero(saturated)) / num_object;
}

}  // namespace rigcal
