#include "core/image/undistort.h"

#include <opencv2/imgproc.hpp>

namespace rigcal {

Eigen::Vector2d OriginalFromUndistorted(const Camera& camera, const Eigen::Vector2d& x_px) {
  if (!camera.HasDistortion()) return x_px;
  const Eigen::Vector3d ray = *RayInCam(Undistorted(camera), x_px);  // a pinhole always has a ray
  Eigen::Vector2d original;
  const IntrinsicVector intrinsics = camera.Intrinsics();
  ProjectPoint(intrinsics.data(), ray, original.data());
  return original;
}

cv::Mat Undistort(const cv::Mat& image, const Camera& camera) {
  if (!camera.HasDistortion()) return image;
  cv::Mat1f map_x(image.size()), map_y(image.size());
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector2d original = OriginalFromUndistorted(camera, {x, y});
      map_x(y, x) = static_cast<float>(original.x());
      map_y(y, x) = static_cast<float>(original.y());
    }
  }
  cv::Mat undistorted;
  const int interpolation = image.depth() == CV_8U && image.channels() == 1 ? cv::INTER_LINEAR : cv::INTER_CUBIC;
  cv::remap(image, undistorted, map_x, map_y, interpolation, cv::BORDER_CONSTANT);
  return undistorted;
}

}  // namespace rigcal
