#include "core/match/window_texture.h"

#include <cmath>

namespace rigcal {
namespace {

using Lanes = Eigen::Map<Eigen::Array<float, Eigen::Dynamic, 1>>;
using ConstLanes = Eigen::Map<const Eigen::Array<float, Eigen::Dynamic, 1>>;

/// The four-by-four neighbourhood of one sample, located.
struct Neighbourhood {
  const float* first;
  Eigen::Index stride;
  float x;  ///< position within the cell, [0, 1)
  float y;
};

/// Walks over the samples of a window. Positions are kept relative to an integer pixel near the centre, so that floats
/// resolve them to 1e-6 px anywhere in the image.
class WindowWalk {
 public:
  WindowWalk(const cv::Mat1f& image, const Eigen::Vector2d& centre_px)
      : stride_(static_cast<Eigen::Index>(image.step1())) {
    const double base_x = std::floor(centre_px.x()), base_y = std::floor(centre_px.y());
    rest_x_ = static_cast<float>(centre_px.x() - base_x);
    rest_y_ = static_cast<float>(centre_px.y() - base_y);
    base_ = image.ptr<float>(static_cast<int>(base_y) - 1) + static_cast<Eigen::Index>(base_x) - 1;
  }

  [[nodiscard]] Neighbourhood At(float dx, float dy) const {
    const float x = rest_x_ + dx, y = rest_y_ + dy;
    const float x0 = std::floor(x), y0 = std::floor(y);
    return {base_ + static_cast<Eigen::Index>(y0) * stride_ + static_cast<Eigen::Index>(x0), stride_, x - x0, y - y0};
  }

 private:
  const float* base_;
  Eigen::Index stride_;
  float rest_x_, rest_y_;
};

Eigen::Array4f Row(const Neighbourhood& n, int row) {
  return Eigen::Map<const Eigen::Array4f>(n.first + row * n.stride);
}

Eigen::Array4f MixRows(const Neighbourhood& n, const Eigen::Array4f& weights) {
  return (weights[0] * Row(n, 0) + weights[1] * Row(n, 1)) + (weights[2] * Row(n, 2) + weights[3] * Row(n, 3));
}

float SumOfFour(const Eigen::Array4f& a) {
  return (a[0] + a[2]) + (a[1] + a[3]);
}

}  // namespace

bool WindowFits(const cv::Mat1f& image, const WindowShape& shape, const Eigen::Vector2d& centre_px) {
  constexpr int kBorder = 1;  // the cubic kernels' second neighbours
  return CanSample(image, centre_px.x() + shape.min_dx_px, centre_px.y() + shape.min_dy_px, kBorder) &&
         CanSample(image, centre_px.x() + shape.max_dx_px, centre_px.y() + shape.max_dy_px, kBorder);
}

void SampleWindow(const cv::Mat1f& image, const WindowShape& shape, const Eigen::Vector2d& centre_px,
                  const CubicKernel& kernel, WindowValues& values) {
  const WindowWalk walk(image, centre_px);
  const int n = shape.NumSamples();
  for (int k = 0; k < n; ++k) {
    const Neighbourhood at = walk.At(shape.dx_px[k], shape.dy_px[k]);
    values[k] = SumOfFour(kernel.Weights(at.x) * MixRows(at, kernel.Weights(at.y)));
  }
  for (int k = n; k < shape.NumLanes(); ++k) values[k] = 0;
}

void SampleWindowWithGradient(const cv::Mat1f& image, const WindowShape& shape, const Eigen::Vector2d& centre_px,
                              const CubicKernel& kernel, WindowValues& values, WindowValues& by_x, WindowValues& by_y) {
  const WindowWalk walk(image, centre_px);
  const int n = shape.NumSamples();
  for (int k = 0; k < n; ++k) {
    const Neighbourhood at = walk.At(shape.dx_px[k], shape.dy_px[k]);
    const Eigen::Array4f column = MixRows(at, kernel.Weights(at.y));
    const Eigen::Array4f across = kernel.Weights(at.x);
    values[k] = SumOfFour(across * column);
    by_x[k] = SumOfFour(kernel.WeightDerivatives(at.x) * column);
    by_y[k] = SumOfFour(across * MixRows(at, kernel.WeightDerivatives(at.y)));
  }
  for (int k = n; k < shape.NumLanes(); ++k) values[k] = by_x[k] = by_y[k] = 0;
}

void RemoveTrend(const WindowShape& shape, WindowValues& values) {
  const int side = shape.side, half = side / 2;
  float sum = 0, along_u = 0, along_v = 0;
  for (int j = 0, k = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i, ++k) {
      sum += values[k];
      along_u += values[k] * static_cast<float>(i - half);
      along_v += values[k] * static_cast<float>(j - half);
    }
  }
  const float n = static_cast<float>(side * side);
  // Sum of i^2 over the window, i = -half .. half in each of `side` rows.
  const float moment = n * static_cast<float>(half * (half + 1)) / 3;
  const float mean = sum / n, slope_u = along_u / moment, slope_v = along_v / moment;
  for (int j = 0, k = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i, ++k) {
      values[k] -= mean + slope_u * static_cast<float>(i - half) + slope_v * static_cast<float>(j - half);
    }
  }
  for (int k = shape.NumSamples(); k < shape.NumLanes(); ++k) values[k] = 0;
}

std::optional<float> Normalise(const WindowShape& shape, float min_contrast, WindowValues& values) {
  const int n = shape.NumSamples();
  Lanes v(values.data(), shape.NumLanes());
  RemoveTrend(shape, values);
  const float norm = std::sqrt(v.square().sum());
  if (!(norm > min_contrast * std::sqrt(static_cast<float>(n)))) return std::nullopt;
  v *= 1 / norm;
  return norm;
}

float Dot(const WindowShape& shape, const WindowValues& a, const WindowValues& b) {
  return (ConstLanes(a.data(), shape.NumLanes()) * ConstLanes(b.data(), shape.NumLanes())).sum();
}

}  // namespace rigcal
