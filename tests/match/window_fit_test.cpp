#include "core/match/window_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/match/patch_frame.h"
#include "tests/match/synthetic_plane.h"

namespace rigcal {
namespace {

constexpr int kSide = 7;
const cv::Size kSize(120, 120);

/// The texture as a picture that is shifted by shift_px: what lies at x in the texture is seen at x + shift.
cv::Mat1f Picture(const test::WaveTexture& texture, const Eigen::Vector2d& shift_px, double noise = 0,
                  std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat1f image(kSize);
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      image(y, x) = static_cast<float>(texture.At(Eigen::Vector2d(x, y) - shift_px) + noise * random.Normal());
    }
  }
  return image;
}

/// The shape of a patch seen head on, with `step` pixels between samples.
WindowShape StraightShape(int side, double step = 1) {
  WindowShape shape;
  shape.side = side;
  const int half = side / 2;
  for (int k = 0; k < side * side; ++k) {
    shape.dx_px[k] = static_cast<float>(step * (k % side - half));
    shape.dy_px[k] = static_cast<float>(step * (k / side - half));
  }
  shape.max_dx_px = shape.max_dy_px = static_cast<float>(step * half);
  shape.min_dx_px = shape.min_dy_px = -shape.max_dx_px;
  shape.px_from_step = step * Eigen::Matrix2d::Identity();
  return shape;
}

std::optional<WindowTemplate> TemplateAt(const cv::Mat1f& image, const Eigen::Vector2d& centre_px, double step = 1) {
  const auto reference = SampleReference(image, StraightShape(kSide + 2 * kTextureMargin), centre_px);
  return reference ? MakeTemplate(*reference, StraightShape(kSide, step)) : std::nullopt;
}

TEST(WindowTexture, GradientAgreesWithDifferences) {
  const cv::Mat1f image = Picture(test::WaveTexture(4, 30, 0.15, 1), {0, 0});
  const WindowShape shape = StraightShape(kSide, 0.8);
  const Eigen::Vector2d centre(50.3, 47.9);
  constexpr double kStep = 0.01;
  WindowValues values, by_x, by_y, plus, minus;
  SampleWindowWithGradient(image, shape, centre, kMatchingKernel, values, by_x, by_y);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d h = kStep * Eigen::Vector2d::Unit(axis);
    SampleWindow(image, shape, centre + h, kMatchingKernel, plus);
    SampleWindow(image, shape, centre - h, kMatchingKernel, minus);
    for (int k = 0; k < shape.NumSamples(); ++k) {
      EXPECT_NEAR((axis == 0 ? by_x : by_y)[k], (plus[k] - minus[k]) / (2 * kStep), 1e-4);
    }
  }
}

TEST(WindowTemplate, DerivativesAgreeWithDifferences) {
  const cv::Mat1f image = Picture(test::WaveTexture(4, 30, 0.15, 2), {0, 0});
  const Eigen::Vector2d centre(50.3, 47.9);
  constexpr double kStep = 0.01;
  constexpr double kStepOfSearchedView = 0.7;  // the template is blurred, which must not break its derivatives
  const auto t = TemplateAt(image, centre, kStepOfSearchedView);
  ASSERT_TRUE(t);
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d h = kStep * Eigen::Vector2d::Unit(axis);
    const auto plus = TemplateAt(image, centre + h, kStepOfSearchedView);
    const auto minus = TemplateAt(image, centre - h, kStepOfSearchedView);
    ASSERT_TRUE(plus && minus);
    for (int k = 0; k < t->shape.NumSamples(); ++k) {
      EXPECT_NEAR((axis == 0 ? t->by_u : t->by_v)[k], (plus->values[k] - minus->values[k]) / (2 * kStep), 1e-3);
    }
  }
}

/// Mean and spread of (found - true) over a grid of windows.
struct Spread {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d predicted = Eigen::Matrix2d::Zero();
  int count = 0;
};

Spread MatchAll(const cv::Mat1f& from, const cv::Mat1f& to, const Eigen::Vector2d& shift_px) {
  Spread spread;
  for (double y = 12.0; y < kSize.height - 12; y += 4.37) {
    for (double x = 12.0; x < kSize.width - 12; x += 4.37) {
      const auto t = TemplateAt(from, {x, y});
      if (!t) continue;
      const auto fit = FitWindow(to, *t, Eigen::Vector2d(x, y) + shift_px.array().round().matrix(), 2.0);
      if (!fit) continue;
      const Eigen::Vector2d error = fit->centre_px - Eigen::Vector2d(x, y) - shift_px;
      spread.mean += error;
      spread.covariance += error * error.transpose();
      spread.predicted += FitCovariance(*t, *fit);
      ++spread.count;
    }
  }
  spread.mean /= spread.count;
  spread.covariance /= spread.count;
  spread.predicted /= spread.count;
  return spread;
}

TEST(FitWindow, DrawsNothingTowardsThePixelGrid) {
  const test::WaveTexture texture(4, 30, 0.15, 3);
  const cv::Mat1f from = Picture(texture, {0, 0});
  for (const double phase : {0.0, 0.125, 0.25, 0.375, 0.5, -0.25}) {
    const Eigen::Vector2d shift(1 + phase, -phase / 2);
    const Spread spread = MatchAll(from, Picture(texture, shift), shift);
    EXPECT_GT(spread.count, 450);
    EXPECT_LT(spread.mean.norm(), 0.001) << phase;
    EXPECT_LT(std::sqrt(spread.covariance.trace()), 0.01) << phase;
  }
}

TEST(FitWindow, NoiseDrawsNothingTowardsThePixelGrid) {
  const test::WaveTexture texture(4, 30, 0.15, 3);
  for (const double phase : {0.25, 0.5, 0.75}) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    constexpr int kRepetitions = 4;
    for (int i = 0; i < kRepetitions; ++i) {
      const std::uint64_t seed = 10 + 2 * i;
      const Eigen::Vector2d shift(phase, phase);
      mean += MatchAll(Picture(texture, {0, 0}, 0.02, seed), Picture(texture, shift, 0.02, seed + 1), shift).mean;
    }
    // 4 x 480 windows with 0.05 px each: 0.0015 px by chance
    EXPECT_LT((mean / kRepetitions).norm(), 0.006) << phase;
  }
}

TEST(FitCovariance, PredictsTheSpreadThatNoiseCauses) {
  for (const double noise : {0.01, 0.03, 0.06}) {
    const test::WaveTexture texture(5, 30, 0.15, 4);
    const Eigen::Vector2d shift(0.3, -0.4);
    const Spread spread = MatchAll(Picture(texture, {0, 0}, noise, 21), Picture(texture, shift, noise, 22), shift);
    const double actual = std::sqrt(spread.covariance.trace()), predicted = std::sqrt(spread.predicted.trace());
    EXPECT_NEAR(predicted / actual, 1.0, 0.3) << "noise " << noise << ": " << predicted << " for " << actual << " px";
  }
}

TEST(FitCovariance, IsLargeAlongAnEdge) {
  cv::Mat1f edge(kSize);
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) edge(y, x) = static_cast<float>(0.5 + 0.4 * std::tanh((x - 60) / 1.5));
  }
  Random random(5);
  cv::Mat1f noisy = edge.clone();
  for (float& v : noisy) v += static_cast<float>(0.01 * random.Normal());
  const auto t = TemplateAt(edge, {60, 60});
  ASSERT_TRUE(t);
  const auto fit = FitWindow(noisy, *t, {60, 60}, 2.0);
  ASSERT_TRUE(fit);
  const Eigen::Matrix2d covariance = FitCovariance(*t, *fit);
  EXPECT_LT(std::sqrt(covariance(0, 0)), 0.05);
  EXPECT_GT(std::sqrt(covariance(1, 1)), 0.3);
}

TEST(MakeTemplate, RefusesWhatHasNoContrast) {
  EXPECT_FALSE(TemplateAt(cv::Mat1f(kSize, 0.3f), {60, 60}));
  EXPECT_FALSE(TemplateAt(Picture(test::WaveTexture(4, 30, 0.15, 3), {0, 0}), {4, 60}));  // leaves the picture
}

TEST(SearchWindow, FindsWhatGaussNewtonMisses) {
  const test::WaveTexture texture(4, 12, 0.15, 6);
  const Eigen::Vector2d shift(-2.6, 2.2);
  const cv::Mat1f from = Picture(texture, {0, 0}), to = Picture(texture, shift);
  int found = 0, found_by_fit = 0, wrong = 0, count = 0;
  for (double y = 20; y < 100; y += 8.3) {
    for (double x = 20; x < 100; x += 8.3, ++count) {
      const auto t = TemplateAt(from, {x, y});
      ASSERT_TRUE(t);
      const Eigen::Vector2d truth = Eigen::Vector2d(x, y) + shift;
      const auto search = SearchWindow(to, *t, {x, y}, 4.0);
      const auto fit = FitWindow(to, *t, {x, y}, 4.0);
      if (search && (search->centre_px - truth).norm() < 0.05) ++found;
      if (search && (search->centre_px - truth).norm() > 1) ++wrong;
      if (fit && (fit->centre_px - truth).norm() < 0.05) ++found_by_fit;
    }
  }
  EXPECT_GT(found, 0.9 * count);
  EXPECT_LT(found_by_fit, 0.6 * count);
  EXPECT_LE(wrong, 0.01 * count);
}

TEST(SearchWindow, RefusesRepeatedTexture) {
  cv::Mat1f grid(kSize);
  constexpr double kPeriodPx = 5;
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const double wave =
          std::cos(2 * std::numbers::pi * x / kPeriodPx) * std::cos(2 * std::numbers::pi * y / kPeriodPx);
      grid(y, x) = static_cast<float>(0.5 + 0.2 * wave);
    }
  }
  const auto t = TemplateAt(grid, {60, 60});
  ASSERT_TRUE(t);
  EXPECT_FALSE(SearchWindow(grid, *t, {62, 61}, 5.0));
  EXPECT_TRUE(SearchWindow(grid, *t, {60.4, 60}, 1.5));  // only one of the repetitions is in reach
}

}  // namespace
}  // namespace rigcal
