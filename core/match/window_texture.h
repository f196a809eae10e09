#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "core/image/sample.h"

namespace rigcal {

/// A window, its margin included, never has more samples a side, so that all of them live on the stack.
inline constexpr int kMaxWindowPx = 19;
inline constexpr int kMaxWindowSamples = 368;  ///< 19 x 19 rounded up to whole vectors of eight floats
inline constexpr int kSampleLanes = 8;

/// One value per sample of a window, row by row; the entries from the window's last sample up to the next multiple of
/// kSampleLanes are zero wherever sums run over them.
using WindowValues = std::array<float, kMaxWindowSamples>;

/// Where a projected patch's samples lie around its centre, in pixels of the level at work: its shape, which matching
/// keeps fixed (paper section 3.2).
struct WindowShape {
  int side = 0;  ///< samples per side, odd
  WindowValues dx_px;
  WindowValues dy_px;
  float min_dx_px = 0, max_dx_px = 0, min_dy_px = 0, max_dy_px = 0;
  /// d pixel / d sample step along the patch's two axes, at the centre.
  Eigen::Matrix2d px_from_step;

  [[nodiscard]] int NumSamples() const { return side * side; }
  /// Rounded up to whole vectors.
  [[nodiscard]] int NumLanes() const { return (NumSamples() + kSampleLanes - 1) / kSampleLanes * kSampleLanes; }
};

/// Whether all samples of the shape, centred at centre_px, have the neighbours that interpolation needs.
bool WindowFits(const cv::Mat1f& image, const WindowShape& shape, const Eigen::Vector2d& centre_px);

/// The grey values below the window, as the image has them. The caller has asked WindowFits.
void SampleWindow(const cv::Mat1f& image, const WindowShape& shape, const Eigen::Vector2d& centre_px,
                  const CubicKernel& kernel, WindowValues& values);

/// The same with the derivatives by the pixel coordinates.
void SampleWindowWithGradient(const cv::Mat1f& image, const WindowShape& shape, const Eigen::Vector2d& centre_px,
                              const CubicKernel& kernel, WindowValues& values, WindowValues& by_x, WindowValues& by_y);

/// Takes out the part that is linear in the window's rows and columns.
void RemoveTrend(const WindowShape& shape, WindowValues& values);

/// Makes the mean zero and the sum of squares one; returns the factor's inverse (the norm of the values without their
/// mean), or nothing when the root mean square contrast is below min_contrast.
std::optional<float> Normalise(const WindowShape& shape, float min_contrast, WindowValues& values);

/// Sum over the window of a[k] * b[k].
float Dot(const WindowShape& shape, const WindowValues& a, const WindowValues& b);

}  // namespace rigcal
