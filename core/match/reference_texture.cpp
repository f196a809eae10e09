#include "core/match/reference_texture.h"

#include <Eigen/Dense>
#include <algorithm>

namespace rigcal {
namespace {

/// Variance of what blurs a texture on its way into a sample, in px^2 of the picture: the B-spline kernel (1/3) and the
/// pixel's own area (1/12). The lens is not known and comes on top.
constexpr double kBlurPx2 = 1.0 / 3.0 + 1.0 / 12.0;
/// Limits of the blur that two passes of the stencil imitate, in squared steps; negative: sharpening, for views that
/// come closer than the reference.
constexpr double kMinBlurStep2 = -0.3;
constexpr double kMaxBlurStep2 = 2.0;

/// Covariance of the blur that makes the reference's texture look as in the other view, in steps of the patch's grid.
Eigen::Matrix2d BlurDifference(const Eigen::Matrix2d& reference_px_from_step, const Eigen::Matrix2d& px_from_step) {
  const auto blur_in_steps = [](const Eigen::Matrix2d& a) -> Eigen::Matrix2d {
    const Eigen::Matrix2d inverse = a.inverse();
    return kBlurPx2 * inverse * inverse.transpose();
  };
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(blur_in_steps(px_from_step) - blur_in_steps(reference_px_from_step));
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(kMinBlurStep2).cwiseMin(kMaxBlurStep2).asDiagonal() *
         eigen.eigenvectors().transpose();
}

/// One step of the heat equation with the given covariance: `side` samples a side become side - 2.
void Blur(const WindowValues& from, int side, const Eigen::Matrix2f& covariance, WindowValues& to) {
  const float uu = covariance(0, 0) / 2, vv = covariance(1, 1) / 2, uv = covariance(0, 1) / 4;
  const float centre = 1 - 2 * (uu + vv);
  const int inner = side - 2;
  for (int j = 0; j < inner; ++j) {
    const float* above = from.data() + j * side + 1;
    const float* here = above + side;
    const float* below = here + side;
    for (int i = 0; i < inner; ++i) {
      to[j * inner + i] = centre * here[i] + uu * (here[i - 1] + here[i + 1]) + vv * (above[i] + below[i]) +
                          uv * ((above[i - 1] + below[i + 1]) - (above[i + 1] + below[i - 1]));
    }
  }
}

WindowValues Blurred(const WindowValues& values, int side, const Eigen::Matrix2f& half_covariance) {
  WindowValues once, twice;
  Blur(values, side, half_covariance, once);
  Blur(once, side - 2, half_covariance, twice);
  return twice;
}

/// d v / d shift, where v is the normalised texture and `derivative` the derivative of the texture before:
/// (I - v v^T) (derivative - mean) / norm.
void DifferentiateNormalised(const WindowShape& shape, const WindowValues& v, float norm, WindowValues& derivative) {
  const int n = shape.NumSamples();
  RemoveTrend(shape, derivative);
  const float along = Dot(shape, derivative, v);
  for (int k = 0; k < n; ++k) derivative[k] = (derivative[k] - along * v[k]) / norm;
}

}  // namespace

std::optional<ReferenceTexture> SampleReference(const cv::Mat1f& image, const WindowShape& shape,
                                                const Eigen::Vector2d& centre_px) {
  if (!WindowFits(image, shape, centre_px)) return std::nullopt;
  std::optional<ReferenceTexture> reference(std::in_place);
  reference->shape = shape;
  WindowValues by_x, by_y;
  SampleWindowWithGradient(image, shape, centre_px, kMatchingKernel, reference->values, by_x, by_y);
  const Eigen::Matrix2f a = shape.px_from_step.cast<float>();
  for (int k = 0; k < shape.NumLanes(); ++k) {
    reference->by_u[k] = by_x[k] * a(0, 0) + by_y[k] * a(1, 0);
    reference->by_v[k] = by_x[k] * a(0, 1) + by_y[k] * a(1, 1);
  }
  return reference;
}

std::optional<WindowTemplate> MakeTemplate(const ReferenceTexture& reference, const WindowShape& shape) {
  std::optional<WindowTemplate> t(std::in_place);
  t->shape = shape;
  t->reference_px_from_step = reference.shape.px_from_step;
  const Eigen::Matrix2f half = (BlurDifference(reference.shape.px_from_step, shape.px_from_step) / 2).cast<float>();
  t->values = Blurred(reference.values, reference.shape.side, half);
  t->by_u = Blurred(reference.by_u, reference.shape.side, half);
  t->by_v = Blurred(reference.by_v, reference.shape.side, half);
  for (int k = shape.NumSamples(); k < shape.NumLanes(); ++k) t->values[k] = 0;
  const auto norm = Normalise(shape, kMinContrast, t->values);
  if (!norm) return std::nullopt;
  DifferentiateNormalised(shape, t->values, *norm, t->by_u);
  DifferentiateNormalised(shape, t->values, *norm, t->by_v);
  const double uv = Dot(shape, t->by_u, t->by_v);
  t->information << Dot(shape, t->by_u, t->by_u), uv, uv, Dot(shape, t->by_v, t->by_v);
  if (!(t->information.trace() > 0)) return std::nullopt;
  return t;
}

}  // namespace rigcal
