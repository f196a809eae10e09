#include "core/image/silhouette.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/image/dark_background.h"
#include "core/image/mask_regions.h"
#include "core/image/static_background.h"

namespace rigcal {
namespace {

/// Share of a picture that an object may cover. Measured sets (templeSparseRing, squirrel-turntable, simulated
/// studio): 0.10 to 0.45.
constexpr double kLeastShare = 0.02, kMostShare = 0.85;

std::optional<Silhouettes> Accept(Background background, std::vector<cv::Mat1b> masks) {
  Silhouettes found{background, std::move(masks), {}};
  for (const cv::Mat1b& mask : found.masks) {
    const double share = cv::countNonZero(mask) / static_cast<double>(mask.total());
    if (share < kLeastShare || share > kMostShare) return std::nullopt;
    found.object_share.push_back(share);
  }
  return found;
}

}  // namespace

Silhouettes FindSilhouettes(const std::vector<cv::Mat1f>& pictures, const Execution& execution) {
  if (auto masks = MasksOnDark(pictures, execution); !masks.empty()) {
    if (auto found = Accept(Background::kDark, std::move(masks))) return std::move(*found);
  }
  if (auto masks = MasksOnStatic(pictures, execution); !masks.empty()) {
    if (auto found = Accept(Background::kStatic, std::move(masks))) return std::move(*found);
  }
  return {Background::kNone, std::vector<cv::Mat1b>(pictures.size()), std::vector<double>(pictures.size(), 1.0)};
}

}  // namespace rigcal
