#pragma once

#include <opencv2/core.hpp>

#include "core/scene/board.h"
#include "core/seed/judge_layout.h"

namespace rigcal {

/// Why a picture (8 bits, gamma-encoded) shows no tag of the board: it is a mirror image, tags of another family or
/// with another border are there, it is over-exposed, too dark or blurred; else that nothing was seen. Takes as long as
/// a dozen searches.
ChartFinding ExplainAbsence(const cv::Mat1b& picture, const Board& board);

}  // namespace rigcal
