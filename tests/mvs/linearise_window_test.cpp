#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/mvs/window.h"
#include "tests/support/synthetic_surface.h"

namespace rigcal::stereo {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kSidePx = 96;
constexpr int kView = 2;
using Vector5d = Eigen::Matrix<double, 5, 1>;  // w, dw/du, dw/dv, offset x, offset y

/// A picture that is a bilinear function of the pixel, as are its derivatives: bilinear samples of all of them are
/// exact, so that LineariseWindow has to agree with differences up to rounding.
constexpr double kByX = 0.02, kByY = -0.013, kByXY = 0.003, kMiddlePx = 40;

double BilinearValue(double x_px, double y_px) {
  const double x = x_px - kMiddlePx, y = y_px - kMiddlePx;
  return 0.5 + kByX * x + kByY * y + kByXY * x * y;
}

cv::Mat4f BilinearTexels() {
  cv::Mat4f texels(kSidePx, kSidePx);
  for (int y = 0; y < kSidePx; ++y) {
    for (int x = 0; x < kSidePx; ++x) {
      texels(y, x) = {static_cast<float>(BilinearValue(x, y)), static_cast<float>(kByX + kByXY * (y - kMiddlePx)),
                      static_cast<float>(kByY + kByXY * (x - kMiddlePx)), 1.0f};
    }
  }
  return texels;
}

/// A tilted plane in one view, looked at from another; offsets are not zero.
struct Problem {
  StereoScene scene;
  cv::Mat4f texels = BilinearTexels();
  cv::Mat1f gray;  ///< their first channel
  WindowPlane plane;
  Eigen::Vector2f offset_px{2.5f, -3.25f};
  WindowTexture reference;

  [[nodiscard]] std::optional<WindowWarp> Warp(const Vector5d& change) const {
    WindowPlane moved = plane;
    moved.inverse_depth += change.head<3>();
    return MakeWarp(scene, moved, kView, offset_px + change.tail<2>().cast<float>());
  }
  /// |f_j - f_r|^2 / 2, the function whose derivatives LineariseWindow gives.
  [[nodiscard]] double HalfSquare(const Vector5d& change) const {
    return 1 - static_cast<double>(*WindowNcc(gray, scene.options.window_px, *Warp(change), reference));
  }
  [[nodiscard]] ViewNormalEquations Linearised(bool with_offset) const {
    return *LineariseWindow(texels, scene.options.window_px, *Warp(Vector5d::Zero()), reference, with_offset);
  }
  /// Steps of all parameters that move the window's centre, or its edge, by `px` pixels.
  [[nodiscard]] Vector5d Steps(double px) const {
    const double w = px / static_cast<double>(Warp(Vector5d::Zero())->CentreByInverseDepth().norm());
    const double half = scene.options.window_px / 2;
    return {w, w / half, w / half, px, px};
  }
};

Problem MakeProblem() {
  const test::SurfaceScene rendered = test::RenderSurface(test::PlaneAtHeight(0), test::SolidTexture(8, 30, 0.1, 1),
                                                          test::ViewsAboutZ(4, 25 * kDegree), {kSidePx, kSidePx}, 1);
  Problem problem{.scene = *MakeStereoScene(rendered.images, rendered.truth, {.level = 0}, {}),
                  .gray = {},
                  .plane = {},
                  .reference = {}};
  cv::extractChannel(problem.texels, problem.gray, 0);
  problem.plane = *PlaneThrough(problem.scene, 1, 50, 45, {0, 0, 3}, Eigen::Vector3d(0.2, -0.3, 1).normalized());
  problem.reference = *ReferenceTexture(problem.scene, problem.plane);
  return problem;
}

/// The reference shows exactly what the view shows: the residual is 0 at the plane, and there the Gauss-Newton hessian
/// is the hessian.
void LetReferenceShowTheView(Problem& problem) {
  const WindowWarp warp = *problem.Warp(Vector5d::Zero());
  const int h = problem.scene.options.window_px / 2;
  WindowTexture& r = problem.reference;
  int k = 0;
  for (int dv = -h; dv <= h; ++dv) {
    for (int du = -h; du <= h; ++du, ++k) {
      const Eigen::Vector3f q = warp.centre + warp.by_u * static_cast<float>(du) + warp.by_v * static_cast<float>(dv);
      const Eigen::Vector2f x_px = q.head<2>() / q.z() + warp.offset_px;
      r.normalised[k] = static_cast<float>(BilinearValue(x_px.x(), x_px.y()));
    }
  }
  r.normalised = r.root_weight * (r.normalised - (r.weight * r.normalised).sum());
  r.normalised /= std::sqrt(r.normalised.square().sum());
}

TEST(LineariseWindow, GradientAgreesWithDifferences) {
  const Problem problem = MakeProblem();
  const ViewNormalEquations linearised = problem.Linearised(true);
  EXPECT_NEAR(linearised.ncc, 1 - problem.HalfSquare(Vector5d::Zero()), 1e-5);
  const Vector5d steps = problem.Steps(0.25);
  for (int i = 0; i < 5; ++i) {
    const Vector5d step = Vector5d::Unit(i) * steps[i];
    // Central differences of fourth order, per step.
    const double by_step = (8 * (problem.HalfSquare(step) - problem.HalfSquare(-step)) -
                            (problem.HalfSquare(2 * step) - problem.HalfSquare(-2 * step))) /
                           12;
    EXPECT_GT(std::abs(by_step), 1e-4) << "parameter " << i << " changes nothing: nothing was tested";
    EXPECT_NEAR(linearised.gradient[i] * steps[i], by_step, 2e-6) << "parameter " << i;
  }
}

TEST(LineariseWindow, HessianIsThatOfAnExactFit) {
  Problem problem = MakeProblem();
  LetReferenceShowTheView(problem);
  const ViewNormalEquations linearised = problem.Linearised(true);
  EXPECT_NEAR(linearised.ncc, 1, 1e-5);
  const Vector5d steps = problem.Steps(0.5);
  EXPECT_NEAR((linearised.gradient.array() * steps.array()).matrix().norm(), 0, 1e-5);
  Eigen::Matrix<double, 5, 5> by_steps, expected;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      const Vector5d a = Vector5d::Unit(i) * steps[i], b = Vector5d::Unit(j) * steps[j];
      by_steps(i, j) = (problem.HalfSquare(a + b) - problem.HalfSquare(a - b) - problem.HalfSquare(b - a) +
                        problem.HalfSquare(-a - b)) /
                       4;
      expected(i, j) = linearised.hessian(i, j) * steps[i] * steps[j];
    }
  }
  EXPECT_GT(expected.diagonal().minCoeff(), 1e-4);
  // Differences of second order over half a pixel.
  EXPECT_LT((by_steps - expected).norm() / expected.norm(), 0.02) << by_steps << "\n\n" << expected;
}

TEST(LineariseWindow, HasNoOffsetWhereNoneIsWanted) {
  const Problem problem = MakeProblem();
  const ViewNormalEquations with = problem.Linearised(true), without = problem.Linearised(false);
  EXPECT_EQ(without.ncc, with.ncc);
  EXPECT_EQ(without.gradient.head<3>(), with.gradient.head<3>());
  EXPECT_EQ((without.hessian.topLeftCorner<3, 3>()), (with.hessian.topLeftCorner<3, 3>()));
  EXPECT_EQ(without.gradient.tail<2>().norm(), 0);
  EXPECT_EQ((without.hessian.rightCols<2>().norm()), 0);
  EXPECT_EQ((without.hessian.bottomRows<2>().norm()), 0);
}

}  // namespace
}  // namespace rigcal::stereo
