#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

namespace rigcal {

/// A grey value and its derivative by the pixel coordinates.
struct SampleWithGradient {
  float value;
  float by_x;
  float by_y;
};

/// Whether a sample at (x, y) with `border` further pixels around its four neighbours lies inside the image.
inline bool CanSample(const cv::Mat1f& image, double x, double y, int border) {
  return x >= border && y >= border && x < image.cols - 1 - border && y < image.rows - 1 - border;
}

/// A separable cubic kernel over four neighbours: the weights of pixels -1, 0, 1, 2 at t in [0, 1) from pixel 0 are
/// power[0] + power[1] t + power[2] t^2 + power[3] t^3.
struct CubicKernel {
  std::array<std::array<float, 4>, 4> power;

  [[nodiscard]] Eigen::Array4f Weights(float t) const {
    return Power(0) + t * (Power(1) + t * (Power(2) + t * Power(3)));
  }
  [[nodiscard]] Eigen::Array4f WeightDerivatives(float t) const {
    return Power(1) + t * (2 * Power(2) + t * 3 * Power(3));
  }

 private:
  [[nodiscard]] Eigen::Array4f Power(int i) const { return Eigen::Map<const Eigen::Array4f>(power[i].data()); }
};

/// Interpolates: passes through the pixels.
inline constexpr CubicKernel kCatmullRom{
    {{{0, 1, 0, 0}, {-0.5f, 0, 0.5f, 0}, {1, -2.5f, 2, -0.5f}, {-0.5f, 1.5f, -1.5f, 0.5f}}}};

/// The cubic B-spline with the pixels as coefficients: smooths (variance 1/3 px^2), and smooths alike at every
/// position between the pixels, so that neither noise nor aliasing draws a match towards the pixel grid.
inline constexpr CubicKernel kCubicBSpline{
    {{{1 / 6.f, 4 / 6.f, 1 / 6.f, 0}, {-0.5f, 0, 0.5f, 0}, {0.5f, -1, 0.5f, 0}, {-1 / 6.f, 0.5f, -0.5f, 1 / 6.f}}}};

/// Bilinear interpolation; the caller has asked CanSample(image, x, y, 0).
inline float SampleBilinear(const cv::Mat1f& image, float x, float y) {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  const float* p = image.ptr<float>(y0) + x0;
  const float* q = image.ptr<float>(y0 + 1) + x0;
  const float top = p[0] + a * (p[1] - p[0]);
  const float bottom = q[0] + a * (q[1] - q[0]);
  return top + b * (bottom - top);
}

/// Catmull-Rom (cubic convolution, a = -1/2) interpolation with its exact gradient; the caller has asked
/// CanSample(image, x, y, 1). Its value has no bias towards the pixel grid to third order, which bilinear values have.
inline SampleWithGradient SampleCubic(const cv::Mat1f& image, float x, float y) {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  const auto weights = [](float t, float w[4], float d[4]) {
    const float t2 = t * t, t3 = t2 * t;
    w[0] = 0.5f * (-t3 + 2 * t2 - t), w[1] = 0.5f * (3 * t3 - 5 * t2 + 2);
    w[2] = 0.5f * (-3 * t3 + 4 * t2 + t), w[3] = 0.5f * (t3 - t2);
    d[0] = 0.5f * (-3 * t2 + 4 * t - 1), d[1] = 0.5f * (9 * t2 - 10 * t);
    d[2] = 0.5f * (-9 * t2 + 8 * t + 1), d[3] = 0.5f * (3 * t2 - 2 * t);
  };
  float wx[4], dx[4], wy[4], dy[4];
  weights(a, wx, dx);
  weights(b, wy, dy);
  SampleWithGradient s{0, 0, 0};
  for (int r = 0; r < 4; ++r) {
    const float* p = image.ptr<float>(y0 - 1 + r) + x0 - 1;
    const float row = wx[0] * p[0] + wx[1] * p[1] + wx[2] * p[2] + wx[3] * p[3];
    const float row_by_x = dx[0] * p[0] + dx[1] * p[1] + dx[2] * p[2] + dx[3] * p[3];
    s.value += wy[r] * row;
    s.by_x += wy[r] * row_by_x;
    s.by_y += dy[r] * row;
  }
  return s;
}

}  // namespace rigcal
