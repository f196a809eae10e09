#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "core/scene/board.h"
#include "core/seed/tag_family.h"

namespace rigcal {

/// A tag in a picture, not yet refined. Corners in the order of TagCornerInBoard; pixel (0,0) is the centre of the
/// top-left pixel.
struct FoundTag {
  int id = 0;
  int wrong_cells = 0;  ///< of its code, corrected
  std::array<Eigen::Vector2d, kCornersPerTag> corners_px = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(),
                                                            Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};

  [[nodiscard]] Eigen::Vector2d Centre() const;
  /// The shortest of the four edges.
  [[nodiscard]] double ShortestEdgePx() const;
};

/// libapriltag puts the origin of pixel coordinates at the corner of the top-left pixel, this program at its centre:
/// x = x_apriltag - kAprilTagPixelOffset. The only place of this constant.
inline constexpr double kAprilTagPixelOffset = 0.5;

/// All tags of the family that libapriltag sees in a picture of 8 bits (as bright as for the eye: gamma-encoded), in
/// the order of their ids. The same id may come twice. Also finds what is not there, with families of few bits above
/// all.
std::vector<FoundTag> FindTags(const cv::Mat1b& picture, const TagFamily& family);

}  // namespace rigcal
