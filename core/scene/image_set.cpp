#include "core/scene/image_set.h"

#include <cmath>

namespace rigcal {

bool ViewImages::IsObject(const Eigen::Vector2d& x_px) const {
  const double x = std::round(x_px.x()), y = std::round(x_px.y());
  const cv::Size size = SizePx();
  if (!(x >= 0 && y >= 0 && x < size.width && y < size.height)) return false;
  return mask.empty() || mask(static_cast<int>(y), static_cast<int>(x)) >= kMaskThreshold;
}

}  // namespace rigcal
