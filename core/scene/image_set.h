#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/image/mask_regions.h"
#include "core/image/pyramid.h"

namespace rigcal {

/// One view's picture as the stages see it: undistorted, grey, in [0, 1], with its pyramid.
struct ViewImages {
  std::string name;
  Pyramid gray;
  cv::Mat1b mask;    ///< full size, >= kMaskThreshold is object; empty: everything counts
  cv::Mat3b colour;  ///< BGR at level colour_level, for colouring patches only; may be empty
  int colour_level = 0;
  Camera undistorted_with;  ///< the camera whose distortion was taken out; maps back to the original picture

  [[nodiscard]] cv::Size SizePx() const { return gray[0].size(); }
  /// Whether a full-size pixel position lies inside the image and on the object.
  [[nodiscard]] bool IsObject(const Eigen::Vector2d& x_px) const;
};

/// Same order as RigCalibration::views.
struct ImageSet {
  std::vector<ViewImages> views;
  [[nodiscard]] int NumViews() const { return static_cast<int>(views.size()); }
  [[nodiscard]] int NumLevels() const { return views.empty() ? 0 : static_cast<int>(views[0].gray.size()); }
};

}  // namespace rigcal
