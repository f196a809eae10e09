#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/scene/board.h"
#include "core/seed/find_tags.h"

namespace rigcal {

/// Looks for the tags of the board that are not among `found`, at the places where the nearest ones predict them:
/// a homography of the neighbourhood, so that lens distortion does not matter, growing from tag to tag. What is there
/// must agree with the code of the id that is expected: the cells that differ must be no more than the code can stand,
/// and the grey values correlate with the printed pattern. `found` must agree with the board (JudgeLayout). Ordered by
/// id.
std::vector<FoundTag> PredictTags(const cv::Mat1f& picture, const Board& board, const TagFamily& family,
                                  const std::vector<FoundTag>& found);

/// Where a tag should be, by the tags nearest to it on the board (itself left out).
std::optional<std::array<Eigen::Vector2d, kCornersPerTag>> PredictCorners(const Board& board, int id,
                                                                          const std::vector<FoundTag>& neighbours);

}  // namespace rigcal
