#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

namespace rigcal {

/// Grey values in [0, 1] as the camera gave them: proportional to light, or sRGB-encoded.
struct RecordedPicture {
  cv::Mat1f values;
  bool linear = false;
};

/// What stands around a corner of a tag in the picture. Edges 0 and 1 run from the corner along two sides of the tag.
struct CornerPlace {
  Eigen::Vector2d x_px = Eigen::Vector2d::Zero();  ///< roughly, to be refined
  std::array<Eigen::Vector2d, 2> along;            ///< unit vectors along the edges, to the next corners
  std::array<double, 2> length_px = {0, 0};        ///< of the edges
  std::array<double, 2> inside_px = {0, 0};        ///< the tag is plain to this distance across the edge
  std::array<double, 2> outside_px = {0, 0};       ///< and so is what is around it
  /// A dark square touches the corner from outside (Kalibr's boards): two dark and two bright quadrants meet. Otherwise
  /// one quadrant differs from the three others.
  bool is_crossing = false;
};

struct CornerLimits {
  /// Shift from the rough place, as a share of the plain distance inside; the edge of the next cell lies at 1.
  double max_shift_share = 0.35;
  double min_shift_px = 1.0;  ///< shifts up to this are always allowed
  /// Of the contrast: 0.02 to 0.06 on photographs, 0.2 and more where something hides the corner.
  double max_residual = 0.12;
  double min_contrast = 0.03;  ///< of grey values in [0, 1]
  /// Blur (standard deviation) by the plain distance inside. Beyond, the next cells show: at 0.3 corners lie 0.04 of
  /// the blur towards the dark (measured).
  double max_blur_share = 0.35;
  double max_sigma_px = 0.5;  ///< of the refined place, in its worst direction
};

struct RefinedCorner {
  Eigen::Vector2d x_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
  double blur_px = 0;   ///< standard deviation of the Gaussian that blurs the edges
  double contrast = 0;  ///< bright minus dark
  double residual = 0;  ///< root mean square of what the fit leaves over, as a share of the contrast
};

/// Fits two straight edges, blurred in light and then encoded as the picture is, their crossing, the brightness on both
/// sides and its slope to the pixels around a corner. (Blur in encoded values would move edges towards the dark.) The
/// covariance follows from the fit's own residual, raised by kModelSigmaPx. Nothing when the limits are not met or the
/// place is at the rim of the picture.
std::optional<RefinedCorner> RefineCorner(const RecordedPicture& picture, const CornerPlace& place,
                                          const CornerLimits& limits = {});

/// What a fit of straight, Gaussian-blurred edges leaves out (pixel grid, curved edges, print), per axis: on rendered
/// boards without noise corners are off by this much.
inline constexpr double kModelSigmaPx = 0.006;

}  // namespace rigcal
