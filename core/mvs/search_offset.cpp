#include <Eigen/LU>
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

}  // namespace

std::optional<OffsetMatch> SearchOffset(const cv::Mat4f& texels, int window_px, const WindowWarp& warp,
                                        const WindowTexture& reference, int radius_px) {
  int radius = std::min(radius_px, kMaxSearchRadiusPx);
  while (radius >= 0 && !CanSampleWindow(texels, window_px + 2 * radius, warp)) --radius;
  if (radius < 0) return std::nullopt;
  const int side = window_px + 2 * radius;
  WindowPlaces<kMaxRegionSide> places;
  PlaceWindow(side, warp, places);
  std::array<float, kMaxRegionSide * kMaxRegionSide> region;
  const float centre_value = SampleGray(texels, warp.CentrePx().x(), warp.CentrePx().y());
  for (int k = 0; k < side * side; ++k) region[k] = SampleGray(texels, places.x[k], places.y[k]) - centre_value;
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
