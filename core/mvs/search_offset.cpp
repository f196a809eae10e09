#include <Eigen/LU>
#include <array>
#include <cmath>

#include "core/mvs/window_samples.h"

namespace rigcal::stereo {
namespace {

constexpr int kMaxRegionSide = kMaxStereoWindowPx + 2 * kMaxSearchRadiusPx;
constexpr int kMaxShifts = 2 * kMaxSearchRadiusPx + 1;
using Shifts = Eigen::Array<float, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxShifts, 1>;

/// NCC of the reference with the windows whose first row is `row` of the region, one for each shift along the row.
Shifts NccAlongRow(const std::array<float, kMaxRegionSide * kMaxRegionSide>& region, int region_side, int row,
                   int window_px, const WindowTexture& reference) {
  const int shifts = region_side - window_px + 1;
  Shifts mean = Shifts::Zero(shifts), square = Shifts::Zero(shifts), product = Shifts::Zero(shifts);
  // sum of root_weight * normalised is 0, so the window's mean drops out of the product.
  for (int v = 0, k = 0; v < window_px; ++v) {
    for (int u = 0; u < window_px; ++u, ++k) {
      const Eigen::Map<const Eigen::ArrayXf> values(region.data() + (row + v) * region_side + u, shifts);
      mean += reference.weight[k] * values;
      square += reference.weight[k] * values.square();
      product += reference.root_weight[k] * reference.normalised[k] * values;
    }
  }
  const Shifts variance = square - mean.square();
  return (variance > kMinWindowContrast * kMinWindowContrast)
      .select(product / variance.max(kMinWindowContrast * kMinWindowContrast).sqrt(), 0.0f);
}

/// Grey values of a square of samples about the warp's centre, less the one at the centre (for the rounding's sake).
void SampleRegion(const cv::Mat1f& gray, int side, const WindowWarp& warp,
                  std::array<float, kMaxRegionSide * kMaxRegionSide>& region) {
  std::array<float, kMaxRegionSide> x, y;
  const int half = side / 2;
  for (int row = 0; row < side; ++row) {
    const Eigen::Vector3f left =
        warp.centre + warp.by_v * static_cast<float>(row - half) - warp.by_u * static_cast<float>(half);
    for (int i = 0; i < side; ++i) {
      const float d = static_cast<float>(i), scale = 1 / (left.z() + warp.by_u.z() * d);
      x[i] = (left.x() + warp.by_u.x() * d) * scale + warp.offset_px.x();
      y[i] = (left.y() + warp.by_u.y() * d) * scale + warp.offset_px.y();
    }
    SampleGrays(gray, x.data(), y.data(), side, region.data() + row * side);
  }
  const float centre_value = region[half * side + half];
  for (int k = 0; k < side * side; ++k) region[k] -= centre_value;
}

}  // namespace

std::optional<OffsetMatch> SearchOffset(const cv::Mat1f& gray, int window_px, const WindowWarp& warp,
                                        const WindowTexture& reference, int radius_px) {
  int radius = std::min(radius_px, kMaxSearchRadiusPx);
  while (radius >= 0 && !CanSampleWindow(gray.size(), window_px + 2 * radius, warp)) --radius;
  if (radius < 0) return std::nullopt;
  const int side = window_px + 2 * radius;
  std::array<float, kMaxRegionSide * kMaxRegionSide> region{};
  SampleRegion(gray, side, warp, region);
  OffsetMatch best{warp.offset_px, -1};
  for (int row = 0; row <= 2 * radius; ++row) {
    Eigen::Index column = 0;
    const float ncc = NccAlongRow(region, side, row, window_px, reference).maxCoeff(&column);
    if (ncc <= best.ncc) continue;
    const Eigen::Vector2f shift(static_cast<float>(column) - static_cast<float>(radius),
                                static_cast<float>(row - radius));
    best = {warp.offset_px + warp.PxByReferencePx() * shift, ncc};
  }
  return best;
}

}  // namespace rigcal::stereo
