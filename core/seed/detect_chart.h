#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "core/base/result.h"
#include "core/scene/board.h"
#include "core/scene/chart_sighting.h"
#include "core/seed/judge_layout.h"
#include "core/seed/refine_corner.h"

namespace rigcal {

struct ChartOptions {
  /// Whether grey values are proportional to light; otherwise they are taken to be sRGB-encoded. Blur happens in light:
  /// with encoded values taken for light, corners of tags lie 0.6 px towards the tag's centre (blur of 0.8 px;
  /// crossings on Kalibr's boards stay where they are, tests/seed).
  bool linear = false;
  bool predict = true;   ///< look for missing tags where the others predict them
  bool diagnose = true;  ///< when nothing is found, try mirror images, other families and borders
  CornerLimits limits;
};

struct ChartDetection {
  std::vector<ChartCorner> corners;  ///< by tag, then by corner; a corner that cannot be trusted is left out
  int num_tags = 0;                  ///< with at least one corner
  int num_predicted = 0;             ///< of these, seen only where others predicted them
  double blur_px = 0;                ///< median over the corners
  std::vector<ChartFinding> findings;
};

/// Finds the board in one picture (grey, in [0, 1], with its lens distortion). The same picture gives the same bytes;
/// one thread. A picture without a board is no error but a finding. Errors: kBadInput: a board that cannot be (family,
/// border, ids beyond the family's codes), an empty picture.
Result<ChartDetection> DetectChart(const cv::Mat1f& picture, const Board& board, const ChartOptions& options = {});

}  // namespace rigcal
