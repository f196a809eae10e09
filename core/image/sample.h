#pragma once

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
