#pragma once

#include <Eigen/Core>
#include <array>

#include "core/mvs/window.h"

namespace rigcal::stereo {

/// Whether all samples of a square of `side` samples about the warp's centre have their four neighbours in the image: a
/// plane's homography keeps it convex, so the corners decide.
inline bool CanSampleWindow(const cv::Mat4f& texels, int side, const WindowWarp& warp) {
  const float h = static_cast<float>(side / 2);
  const float last_x = static_cast<float>(texels.cols - 1), last_y = static_cast<float>(texels.rows - 1);
  for (const float dv : {-h, h}) {
    for (const float du : {-h, h}) {
      const Eigen::Vector3f q = warp.centre + warp.by_u * du + warp.by_v * dv;
      if (!(q.z() > 0)) return false;
      const Eigen::Vector2f x = q.head<2>() / q.z() + warp.offset_px;
      if (!(x.x() >= 0 && x.y() >= 0 && x.x() < last_x && x.y() < last_y)) return false;
    }
  }
  return true;
}

/// Bilinear, all channels; the caller has made sure that the four neighbours lie in the image.
inline Eigen::Array4f SampleTexel(const cv::Mat4f& texels, float x, float y) {
  using Texel = Eigen::Map<const Eigen::Array4f>;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float* p = texels.ptr<float>(y0) + 4 * x0;
  const float* q = p + texels.step1();
  const Eigen::Array4f left = Texel(p) + (y - static_cast<float>(y0)) * (Texel(q) - Texel(p));
  const Eigen::Array4f right = Texel(p + 4) + (y - static_cast<float>(y0)) * (Texel(q + 4) - Texel(p + 4));
  return left + (x - static_cast<float>(x0)) * (right - left);
}

/// The same for the grey value alone.
inline float SampleGray(const cv::Mat4f& texels, float x, float y) {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  const float* p = texels.ptr<float>(y0) + 4 * x0;
  const float* q = p + texels.step1();
  const float top = p[0] + a * (p[4] - p[0]);
  return top + b * (q[0] + a * (q[4] - q[0]) - top);
}

/// Where the samples of a window lie in a view, row by row, and 1 / depth relative to the centre's.
template <int kMaxSide>
struct WindowPlaces {
  std::array<float, kMaxSide * kMaxSide> x, y, scale;
};

template <int kMaxSide>
void PlaceWindow(int side, const WindowWarp& warp, WindowPlaces<kMaxSide>& places) {
  const int h = side / 2;
  for (int row = 0; row < side; ++row) {
    const Eigen::Vector3f left =
        warp.centre + warp.by_v * static_cast<float>(row - h) - warp.by_u * static_cast<float>(h);
    float* x = places.x.data() + row * side;
    float* y = places.y.data() + row * side;
    float* scale = places.scale.data() + row * side;
    for (int i = 0; i < side; ++i) {
      const float d = static_cast<float>(i);
      scale[i] = 1 / (left.z() + warp.by_u.z() * d);
      x[i] = (left.x() + warp.by_u.x() * d) * scale[i] + warp.offset_px.x();
      y[i] = (left.y() + warp.by_u.y() * d) * scale[i] + warp.offset_px.y();
    }
  }
}

}  // namespace rigcal::stereo
