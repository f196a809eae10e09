#include <algorithm>
#include <cmath>
#include <vector>

#include "core/match/window_fit.h"

namespace rigcal {
namespace {

/// A peak that reaches the best one's NCC up to this leaves open which of the two is right.
constexpr float kAmbiguousNcc = 0.05f;
/// On the one-pixel grid a peak may be missed by half a pixel each way, so a second one is looked at closely when it is
/// within this of the first.
constexpr float kGridNccLoss = 0.2f;
/// Fits that end closer together than this are the same peak.
constexpr double kSamePeakPx = 1.0;
/// From a grid point, the peak is at most 0.7 px away; more than twice that is another one.
constexpr double kMaxMoveFromGridPx = 1.5;

/// NCC at the points of a square grid of one-pixel spacing around the start; -1 outside the disc or the picture.
struct NccGrid {
  int radius;
  std::vector<float> ncc;

  [[nodiscard]] float At(int x, int y) const {
    if (std::abs(x) > radius || std::abs(y) > radius) return -1;
    return ncc[static_cast<std::size_t>((y + radius) * (2 * radius + 1) + x + radius)];
  }
  [[nodiscard]] bool IsPeak(int x, int y) const {
    const float here = At(x, y);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if ((dx != 0 || dy != 0) && At(x + dx, y + dy) > here) return false;
      }
    }
    return here > 0;
  }
};

struct Peak {
  int x, y;
  float ncc;
};

/// Best first; at equal NCC the order of the grid decides.
std::vector<Peak> PeaksOf(const NccGrid& grid) {
  std::vector<Peak> peaks;
  for (int y = -grid.radius; y <= grid.radius; ++y) {
    for (int x = -grid.radius; x <= grid.radius; ++x) {
      if (grid.IsPeak(x, y)) peaks.push_back({x, y, grid.At(x, y)});
    }
  }
  std::stable_sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.ncc > b.ncc; });
  return peaks;
}

}  // namespace

std::optional<WindowFit> SearchWindow(const cv::Mat1f& image, const WindowTemplate& sought,
                                      const Eigen::Vector2d& start_px, double radius_px) {
  const int radius = static_cast<int>(std::ceil(radius_px));
  NccGrid grid{radius, {}};
  grid.ncc.reserve(static_cast<std::size_t>((2 * radius + 1) * (2 * radius + 1)));
  WindowValues values;
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const bool inside = std::hypot(x, y) <= radius_px + 0.5;
      grid.ncc.push_back(inside ? NccAt(image, sought, start_px + Eigen::Vector2d(x, y), values).value_or(-1) : -1);
    }
  }
  std::optional<WindowFit> best;
  float best_grid_ncc = 0;
  for (const Peak& peak : PeaksOf(grid)) {
    if (best && peak.ncc < best_grid_ncc - kGridNccLoss) break;
    const auto fit = FitWindow(image, sought, start_px + Eigen::Vector2d(peak.x, peak.y), kMaxMoveFromGridPx);
    if (!fit) continue;
    if (!best) {
      best = fit;
      best_grid_ncc = peak.ncc;
    } else if ((fit->centre_px - best->centre_px).norm() > kSamePeakPx) {
      if (std::abs(fit->ncc - best->ncc) < kAmbiguousNcc) return std::nullopt;
      if (fit->ncc > best->ncc) best = fit;
    }
  }
  return best;
}

}  // namespace rigcal
