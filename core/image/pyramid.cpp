#include "core/image/pyramid.h"

#include <opencv2/imgproc.hpp>

#include "core/base/ensure.h"

namespace rigcal {

Pyramid BuildPyramid(const cv::Mat1f& image, int num_levels) {
  Ensure(!image.empty() && num_levels >= 1, "a pyramid needs an image and at least one level");
  Pyramid levels{image};
  while (static_cast<int>(levels.size()) < num_levels) {
    cv::Mat1f smaller;
    cv::pyrDown(levels.back(), smaller);
    levels.push_back(smaller);
  }
  return levels;
}

}  // namespace rigcal
