#pragma once

#include <opencv2/core.hpp>

#include "core/geometry/camera.h"

namespace rigcal {

/// The image that `Undistorted(camera)` would have taken: cubic interpolation, outside = 0. An image of a camera
/// without distortion is returned as it is. The only place where pictures are undistorted.
cv::Mat Undistort(const cv::Mat& image, const Camera& camera);

/// Where a pixel of the undistorted image lies in the original one (camera: the one given to Undistort).
Eigen::Vector2d OriginalFromUndistorted(const Camera& camera, const Eigen::Vector2d& x_px);

}  // namespace rigcal
