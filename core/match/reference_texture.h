#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/match/window_texture.h"

namespace rigcal {

/// The matching kernel. Measured on synthetic planes turned by 20 degrees (tests/match, shortest wave 3 px, no noise):
/// 0.007 px against 0.043 px with Catmull-Rom; with 1 % noise on smooth texture 0.054 against 0.073 px.
inline constexpr const CubicKernel& kMatchingKernel = kCubicBSpline;

/// Samples beyond the window on each side, which blurring needs: two passes of a 3 x 3 stencil.
inline constexpr int kTextureMargin = 2;

/// Grey values in [0, 1]: root mean square contrast below which a window shows nothing but the rounding of an 8-bit
/// camera, 1 / (255 sqrt(12)).
inline constexpr float kMinContrast = 0.0012f;

/// The grey values q_j0 around the reference feature, as its picture has them, with a margin.
struct ReferenceTexture {
  WindowShape shape;  ///< side + 2 kTextureMargin
  WindowValues values;
  WindowValues by_u;  ///< d value / d (shift along the patch's axes, in sample steps)
  WindowValues by_v;
};

/// `shape` has the margin. Nothing where it leaves the picture.
std::optional<ReferenceTexture> SampleReference(const cv::Mat1f& image, const WindowShape& shape,
                                                const Eigen::Vector2d& centre_px);

/// The texture q_j0 as another view would show it, ready to be found there.
/// The fit is inverse-compositional: what is differentiated is the template, once, not the picture that is searched.
struct WindowTemplate {
  WindowShape shape;    ///< the window of the view it is made for
  WindowValues values;  ///< zero mean, unit norm
  WindowValues by_u;    ///< d values / d (shift of the template along the patch's axes, in sample steps)
  WindowValues by_v;
  Eigen::Matrix2d information;             ///< J^T J of by_u, by_v
  Eigen::Matrix2d reference_px_from_step;  ///< of the reference view
};

/// `shape`: the window in the view that is searched. A view that sees the patch smaller or more slanted than the
/// reference blurs it more (the pixel and the kernel cover more of the surface); the template is blurred by the
/// difference, without which such views are off by 0.03 to 0.07 px. Nothing where there is no contrast.
std::optional<WindowTemplate> MakeTemplate(const ReferenceTexture& reference, const WindowShape& shape);

}  // namespace rigcal
