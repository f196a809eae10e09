#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/match/reference_texture.h"

namespace rigcal {

/// NCC of the texture at centre_px with the template; `values` receives the normalised texture. Nothing where the
/// window leaves the picture or has no contrast.
std::optional<float> NccAt(const cv::Mat1f& image, const WindowTemplate& sought, const Eigen::Vector2d& centre_px,
                           WindowValues& values);

/// Where the template was found in another view.
struct WindowFit {
  Eigen::Vector2d centre_px;  ///< of the level at work
  float ncc = 0;
  WindowValues residual;  ///< normalised texture found minus template
};

/// Moves centre_px, starting from start_px, to where the texture below the window agrees best with the template
/// (argmax NCC of paper section 3.2), by Gauss-Newton on the difference of the normalised textures. Nothing where the
/// window leaves the picture, strays farther than max_move_px from the start, loses NCC or does not settle.
std::optional<WindowFit> FitWindow(const cv::Mat1f& image, const WindowTemplate& sought,
                                   const Eigen::Vector2d& start_px, double max_move_px);

/// The same from a start that may be off by radius_px: looks at every pixel of that neighbourhood first. Nothing also
/// where two places explain the template about equally well.
std::optional<WindowFit> SearchWindow(const cv::Mat1f& image, const WindowTemplate& sought,
                                      const Eigen::Vector2d& start_px, double radius_px);

/// Covariance (px^2 of the level at work) of fit.centre_px relative to the template's place:
/// S^-1 (J^T C J) s^2 S^-1, with J the template's derivatives, S = J^T J without what noise has added to it, s^2 the
/// variance of the residual and C the correlation of its entries, which come from overlapping pixels. (J^T J)^-1 s^2
/// would call the result up to two times too good. Noise of both pictures is in it; each has about half.
Eigen::Matrix2d FitCovariance(const WindowTemplate& sought, const WindowFit& fit);

}  // namespace rigcal
