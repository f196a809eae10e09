#include "core/mvs/fit_plane.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/synthetic_surface.h"

namespace rigcal::stereo {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kNumViews = 6;
constexpr int kMiddlePx = 40, kSidePx = 2 * kMiddlePx + 1;

/// The plane z = 0, from above (view 0) and from five sides; waves of at least 6 pixels.
const test::SurfaceScene& PlaneScene() {
  static const test::SurfaceScene scene =
      test::RenderSurface(test::PlaneAtHeight(0), test::SolidTexture(6, 24, 0.1, 3),
                          test::ViewsAboutZ(kNumViews, 25 * kDegree), {kSidePx, kSidePx}, 1);
  return scene;
}

/// Fits from a plane tilted by 12 degrees, `height` above the true one, to the views 1 to 5.
struct Outcome {
  bool fitted = false;
  PlaneFit fit;
  double height = 0;     ///< of the fitted centre above the true plane
  double tilt_rad = 0;   ///< of the fitted normal
  double px_per_height;  ///< largest shift of the centre in any view, pixels per unit of height
};

Outcome FitFrom(const StereoScene& scene, double height, int u_px = kMiddlePx, int v_px = kMiddlePx) {
  const Eigen::Vector3d tilted(std::sin(12 * kDegree), 0, std::cos(12 * kDegree));
  const WindowPlane truth = *PlaneThrough(scene, 0, u_px, v_px, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d above = CentreInWorld(scene, truth) + height * Eigen::Vector3d::UnitZ();
  Outcome outcome;
  outcome.fit.plane = *PlaneThrough(scene, 0, u_px, v_px, above, tilted);
  for (int view = 1; view < kNumViews; ++view) outcome.fit.others.push_back({.view = view});
  constexpr int kManyIterations = 20;
  constexpr double kConvergedPx = 1e-3;
  outcome.fitted =
      FitPlane(scene, *ReferenceTexture(scene, outcome.fit.plane), kManyIterations, kConvergedPx, outcome.fit);
  outcome.height = CentreInWorld(scene, outcome.fit.plane).z();
  outcome.tilt_rad = std::acos(std::min(1.0, NormalInWorld(scene, outcome.fit.plane).z()));
  // At a tilt of t a height of 1 moves the picture by sin t pixels.
  outcome.px_per_height = std::sin(25 * kDegree);
  return outcome;
}

TEST(FitPlane, ExactCamerasLeadBackToTheTruth) {
  const StereoScene scene = *MakeStereoScene(PlaneScene().images, PlaneScene().truth, {.level = 0}, {});
  ASSERT_FALSE(scene.free_offsets);
  for (const double height : {-3.0, 3.0}) {  // 1.3 pixels in the views
    for (const int u_px : {kMiddlePx - 12, kMiddlePx, kMiddlePx + 10}) {
      const Outcome outcome = FitFrom(scene, height, u_px);
      ASSERT_TRUE(outcome.fitted);
      // What bilinear samples cost: 0.02 pixels.
      EXPECT_LT(std::abs(outcome.height) * outcome.px_per_height, 0.02) << height << " " << u_px;
      EXPECT_LT(outcome.tilt_rad, 1 * kDegree) << height << " " << u_px;
      for (const Sighting& s : outcome.fit.others) EXPECT_GT(s.ncc, 0.99f) << "view " << s.view;
    }
  }
}

TEST(FitPlane, KeepsToTheViewsThatShowTheWindow) {
  const StereoScene scene = *MakeStereoScene(PlaneScene().images, PlaneScene().truth, {.level = 0}, {});
  Outcome outcome = FitFrom(scene, 2);
  // An offset beyond the image's edge: that view says nothing, the others decide.
  PlaneFit fit = outcome.fit;
  fit.others[2].offset_px = {kSidePx, 0};
  ASSERT_TRUE(FitPlane(scene, *ReferenceTexture(scene, fit.plane), 10, 1e-3, fit));
  EXPECT_EQ(fit.others[2].ncc, 0);
  EXPECT_GT(fit.others[1].ncc, 0.99f);
  EXPECT_NEAR(CentreInWorld(scene, fit.plane).z(), 0, 0.05);
  for (Sighting& s : fit.others) s.offset_px = {kSidePx, 0};
  EXPECT_FALSE(FitPlane(scene, *ReferenceTexture(scene, fit.plane), 10, 1e-3, fit)) << "nothing is left to fit";
}

/// The cameras of the views are off by known pixels; each offset is where the texture lies, whatever the plane's depth
/// makes of the part along the epipolar line. Their prior keeps back a few per cent of them.
TEST(FitPlane, FreeOffsetsFindTheTextureInWrongCameras) {
  const std::vector<Eigen::Vector2d> shift_px = {{0, 0}, {1.2, 0.4}, {-0.8, 1}, {0.3, -1.4}, {-1.1, -0.6}, {0.5, 1.3}};
  const RigCalibration wrong = test::WithShiftedViews(PlaneScene().truth, shift_px);
  const StereoOptions options{.level = 0, .expected_error_px = std::vector<double>(kNumViews, 1.2)};
  const StereoScene scene = *MakeStereoScene(PlaneScene().images, wrong, options, {});
  ASSERT_TRUE(scene.free_offsets);
  const Outcome outcome = FitFrom(scene, 0);
  ASSERT_TRUE(outcome.fitted);
  for (const Sighting& s : outcome.fit.others) {
    EXPECT_GT(s.ncc, 0.99f) << "view " << s.view;
    const Eigen::Vector2d texture_px = test::TrueImage(PlaneScene().truth, s.view, Eigen::Vector3d::Zero());
    const WindowWarp warp = *MakeWarp(scene, outcome.fit.plane, s.view, s.offset_px);
    EXPECT_LT((warp.CentrePx().cast<double>() - texture_px).norm(), 0.1) << "view " << s.view;
    EXPECT_LT(s.offset_px.norm(), 3) << "view " << s.view;
  }
  EXPECT_LT(outcome.tilt_rad, 3 * kDegree);
  // The wrong cameras' mean agreement leaves the depth within their own error.
  EXPECT_LT(std::abs(outcome.height) * outcome.px_per_height, 1.2);
}

/// The least squares prior pulls offsets to zero as far as the textures leave it open: exact cameras stay exact.
TEST(FitPlane, FreeOffsetsStayAtZeroInExactCameras) {
  const StereoOptions options{.level = 0, .expected_error_px = std::vector<double>(kNumViews, 1.2)};
  const StereoScene scene = *MakeStereoScene(PlaneScene().images, PlaneScene().truth, options, {});
  const Outcome outcome = FitFrom(scene, 1);
  ASSERT_TRUE(outcome.fitted);
  for (const Sighting& s : outcome.fit.others) EXPECT_LT(s.offset_px.norm(), 0.05) << "view " << s.view;
  EXPECT_LT(std::abs(outcome.height) * outcome.px_per_height, 0.05);
  EXPECT_LT(outcome.tilt_rad, 2 * kDegree);
}

/// sigma_px is the standard deviation of the depth, in pixels of the view that it moves most in.
TEST(FitPlane, SigmaIsWhatNoiseDoes) {
  constexpr int kDraws = 100;
  constexpr double kNoise = 0.02;  // 5 grey values
  double sum_z = 0, sum_z2 = 0, sum_error2_px = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const ImageSet noisy = test::WithNoise(PlaneScene().images, kNoise, static_cast<std::uint64_t>(draw) + 1);
    const StereoScene scene = *MakeStereoScene(noisy, PlaneScene().truth, {.level = 0}, {});
    const Outcome outcome = FitFrom(scene, 1);
    ASSERT_TRUE(outcome.fitted);
    const double error_px = outcome.height * outcome.px_per_height, z = error_px / outcome.fit.sigma_px;
    sum_z += z, sum_z2 += z * z, sum_error2_px += error_px * error_px;
  }
  const double mean = sum_z / kDraws, deviation = std::sqrt(sum_z2 / kDraws - mean * mean);
  RecordProperty("deviation", std::to_string(deviation));
  RecordProperty("error_px", std::to_string(std::sqrt(sum_error2_px / kDraws)));
  EXPECT_GT(std::sqrt(sum_error2_px / kDraws), 0.01) << "the noise does nothing: nothing was tested";
  EXPECT_GT(deviation, 0.6);
  EXPECT_LT(deviation, 1.6);
  EXPECT_LT(std::abs(mean), 0.5);
}

}  // namespace
}  // namespace rigcal::stereo
