#include "core/match/window_texture.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

using Lanes = Eigen::Map<Eigen::Array<float, Eigen::Dynamic, 1>>;
using ConstLanes = Eigen::Map<const Eigen::Array<float, Eigen::Dynamic, 1>>;

/// Column and row of every sample, counted from the window's middle; zero in the lanes beyond the last sample.
struct WindowGrid {
  WindowValues one{};
  WindowValues u{};
  WindowValues v{};
};

constexpr WindowGrid MakeGrid(int side) {
  WindowGrid grid;
  for (int k = 0; k < side * side; ++k) {
    const auto i = static_cast<std::size_t>(k);
    grid.one[i] = 1;
    grid.u[i] = static_cast<float>(k % side - side / 2);
    grid.v[i] = static_cast<float>(k / side - side / 2);
  }
  return grid;
}

/// Of the windows with side 1, 3, 5 ..
constexpr auto kGrids = [] {
  std::array<WindowGrid, kMaxWindowPx / 2 + 1> grids;
  for (int half = 0; half <= kMaxWindowPx / 2; ++half) grids[static_cast<std::size_t>(half)] = MakeGrid(2 * half + 1);
  return grids;
}();

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

[[gnu::always_inline]] inline Eigen::Array4f Row(const Neighbourhood& n, int row) {
  return Eigen::Map<const Eigen::Array4f>(n.first + row * n.stride);
}

/// Inlined by force: half of matching's time is spent here, and the call costs as much as the work.
[[gnu::always_inline]] inline Eigen::Array4f MixRows(const Neighbourhood& n, const Eigen::Array4f& weights) {
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
  std::fill(values.begin() + shape.NumSamples(), values.begin() + shape.NumLanes(), 0.0f);
  const WindowGrid& grid = kGrids[static_cast<std::size_t>(shape.side / 2)];
  const int half = shape.side / 2, lanes = shape.NumLanes();
  const float n = static_cast<float>(shape.NumSamples());
  // Sum of i^2 over the window, i = -half .. half in each of its rows.
  const float moment = std::max(1.0f, n * static_cast<float>(half * (half + 1)) / 3);
  const ConstLanes one(grid.one.data(), lanes), u(grid.u.data(), lanes), v(grid.v.data(), lanes);
  Lanes x(values.data(), lanes);
  const float mean = (x * one).sum() / n, slope_u = (x * u).sum() / moment, slope_v = (x * v).sum() / moment;
  x = one * x - (mean * one + slope_u * u + slope_v * v);
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
