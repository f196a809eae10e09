#pragma once

#include <Eigen/Core>
#include <type_traits>

#include "core/mvs/window.h"

namespace rigcal::stereo {

/// Whether all samples of a square of `side` samples about the warp's centre have their four neighbours in the image: a
/// plane's homography keeps it convex, so the corners decide.
inline bool CanSampleWindow(cv::Size size, int side, const WindowWarp& warp) {
  const float h = static_cast<float>(side / 2);
  const float last_x = static_cast<float>(size.width - 1), last_y = static_cast<float>(size.height - 1);
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
[[gnu::always_inline]] inline Eigen::Array4f SampleTexel(const cv::Mat4f& texels, float x, float y) {
  using Texel = Eigen::Map<const Eigen::Array4f>;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float* p = texels.ptr<float>(y0) + 4 * x0;
  const float* q = p + texels.step1();
  const Eigen::Array4f left = Texel(p) + (y - static_cast<float>(y0)) * (Texel(q) - Texel(p));
  const Eigen::Array4f right = Texel(p + 4) + (y - static_cast<float>(y0)) * (Texel(q + 4) - Texel(p + 4));
  return left + (x - static_cast<float>(x0)) * (right - left);
}

/// Grey values alone, for `count` places at once.
inline void SampleGrays(const cv::Mat1f& gray, const float* x, const float* y, int count, float* values) {
  const float* image = gray.ptr<float>();
  const int stride = static_cast<int>(gray.step1());
  for (int k = 0; k < count; ++k) {
    const int x0 = static_cast<int>(x[k]), y0 = static_cast<int>(y[k]);
    const float a = x[k] - static_cast<float>(x0), b = y[k] - static_cast<float>(y0);
    const int at = y0 * stride + x0;
    const float top = image[at] + a * (image[at + 1] - image[at]);
    const float bottom = image[at + stride] + a * (image[at + stride + 1] - image[at + stride]);
    values[k] = top + b * (bottom - top);
  }
}

/// A window's samples, row by row, padded to whole vectors of 8: the loops over them have a fixed length and no rest.
/// Padding has weight 0 and lies on the window's centre.
template <int kSide>
struct WindowShape {
  static constexpr int kNumSamples = PaddedSamples(kSide);
  using Samples = Eigen::Array<float, kNumSamples, 1>;
  using ConstMap = Eigen::Map<const Samples>;

  /// Columns and rows of the samples from the window's centre.
  struct Grid {
    Samples du, dv;
    Grid() : du(Samples::Zero()), dv(Samples::Zero()) {
      for (int k = 0; k < kSide * kSide; ++k) {
        du[k] = static_cast<float>(k % kSide - kSide / 2), dv[k] = static_cast<float>(k / kSide - kSide / 2);
      }
    }
  };

  /// Where the samples lie in a view, without the warp's offset, and 1 / depth relative to the centre's.
  struct Places {
    Samples x, y, scale;
    Places(const WindowWarp& warp, const Grid& grid) {
      scale = (warp.centre.z() + warp.by_u.z() * grid.du + warp.by_v.z() * grid.dv).inverse();
      x = (warp.centre.x() + warp.by_u.x() * grid.du + warp.by_v.x() * grid.dv) * scale;
      y = (warp.centre.y() + warp.by_u.y() * grid.du + warp.by_v.y() * grid.dv) * scale;
    }
  };
};

/// Calls work(std::integral_constant<int, side>) for the window's side, so that the compiler knows it.
template <typename Work>
auto WithSide(int window_px, const Work& work) {
  static_assert(kMaxStereoWindowPx == 15);
  switch (window_px) {
    case 3:
      return work(std::integral_constant<int, 3>());
    case 5:
      return work(std::integral_constant<int, 5>());
    case 7:
      return work(std::integral_constant<int, 7>());
    case 9:
      return work(std::integral_constant<int, 9>());
    case 11:
      return work(std::integral_constant<int, 11>());
    case 13:
      return work(std::integral_constant<int, 13>());
    default:
      return work(std::integral_constant<int, 15>());
  }
}

}  // namespace rigcal::stereo
