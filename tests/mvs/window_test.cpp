#include "core/mvs/window.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/synthetic_surface.h"

namespace rigcal::stereo {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kSidePx = 96;
constexpr int kNumLevels = 2;

/// The plane z = 0 from straight above (view 0) and from 25 degrees off on five sides. No wave is shorter than 8 pixels
/// of level 1.
const test::SurfaceScene& PlaneScene() {
  static const test::SurfaceScene scene =
      test::RenderSurface(test::PlaneAtHeight(0), test::SolidTexture(16, 60, 0.1, 1),
                          test::ViewsAboutZ(6, 25 * kDegree), {kSidePx, kSidePx}, kNumLevels);
  return scene;
}

StereoScene SceneAtLevel(int level) {
  return *MakeStereoScene(PlaneScene().images, PlaneScene().truth, {.level = level}, {});
}

/// The true plane at a pixel of a view.
WindowPlane TruePlane(const StereoScene& scene, int view, int u_px, int v_px) {
  return *PlaneThrough(scene, view, u_px, v_px, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ());
}

TEST(WindowPlane, KeepsThePointAndTheNormalItWasMadeOf) {
  const StereoScene scene = SceneAtLevel(1);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, 1).normalized(), point(4, -3, 7);
  const WindowPlane plane = *PlaneThrough(scene, 2, 20, 27, point, normal);
  EXPECT_NEAR((NormalInWorld(scene, plane) - normal).norm(), 0, 1e-9);
  const Eigen::Vector3d centre = CentreInWorld(scene, plane);
  EXPECT_NEAR((centre - point).dot(normal), 0, 1e-6);
  const Pixel pixel = *scene.Project(2, centre);
  EXPECT_NEAR((pixel.x_px - Eigen::Vector2d(20, 27)).norm(), 0, 1e-9);
  EXPECT_NEAR(pixel.depth, 1 / plane.inverse_depth[0], 1e-9);
  // The slopes: a pixel further right or down the same plane is at w + dw.
  for (const auto& [u, v, change] : {std::tuple{21, 27, plane.inverse_depth[1]}, {20, 28, plane.inverse_depth[2]}}) {
    const WindowPlane beside = *PlaneThrough(scene, 2, u, v, point, normal);
    EXPECT_NEAR(beside.inverse_depth[0], plane.inverse_depth[0] + change, 1e-15);
  }
}

TEST(WindowPlane, IsNothingFromBehindOrFromItsEdge) {
  const StereoScene scene = SceneAtLevel(0);
  const auto seen_from_view_0 = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    return PlaneThrough(scene, 0, 48, 48, point, normal.normalized()).has_value();
  };
  EXPECT_TRUE(seen_from_view_0({0, 0, 0}, {0, 0, 1}));
  EXPECT_FALSE(seen_from_view_0({0, 0, 0}, {0, 0, -1})) << "its back";
  EXPECT_FALSE(seen_from_view_0({0, 0, 0}, {1, 0, 0.05})) << "its edge";
  EXPECT_FALSE(seen_from_view_0({0, 0, 2 * test::kSceneDistance}, {0, 0, 1})) << "behind the camera";
}

/// Fails when a level is off by half a pixel, when pictures are scaled by something else than 2^l, or when a view is
/// taken for another.
TEST(WindowWarp, AgreesWithProjectingThePlane) {
  for (const int level : {0, 1}) {
    const StereoScene scene = SceneAtLevel(level);
    const double scale = std::ldexp(1.0, -level);
    const int u_px = kSidePx / 2 >> level, v_px = kSidePx / 2 >> level;
    const WindowPlane plane = TruePlane(scene, 1, u_px, v_px);
    const Eigen::Vector2f offset_px(0.25f, -0.5f);
    const WindowWarp warp = *MakeWarp(scene, plane, 3, offset_px);
    for (const double du : {-3.0, 0.0, 3.0}) {
      for (const double dv : {-3.0, 0.0, 3.0}) {
        // The full-size pixel's ray in the true camera, with the plane z = 0, in the true other camera.
        const RigCalibration& truth = PlaneScene().truth;
        const Rigid3d world_from_cam = truth.views[1].cam_from_world.Inverse();
        const Eigen::Vector3d ray =
            world_from_cam.rotation * *RayInCam(truth.CameraOf(1), Eigen::Vector2d(u_px + du, v_px + dv) / scale);
        const Eigen::Vector3d x_in_world =
            world_from_cam.translation - ray * (world_from_cam.translation.z() / ray.z());
        const Eigen::Vector2d expected_px = test::TrueImage(truth, 3, x_in_world) * scale + offset_px.cast<double>();
        const Eigen::Vector3f q = warp.centre + warp.by_u * static_cast<float>(du) + warp.by_v * static_cast<float>(dv);
        const Eigen::Vector2d warped_px = (q.head<2>() / q.z() + warp.offset_px).cast<double>();
        EXPECT_NEAR((warped_px - expected_px).norm(), 0, 1e-4) << level << " " << du << " " << dv;
      }
    }
  }
}

TEST(WindowWarp, DerivativesAgreeWithDifferences) {
  const StereoScene scene = SceneAtLevel(0);
  const WindowPlane plane = TruePlane(scene, 1, 50, 45);
  const WindowWarp warp = *MakeWarp(scene, plane, 2, Eigen::Vector2f::Zero());
  const double step = 1e-3 * plane.inverse_depth[0];  // about half a pixel in view 2
  WindowPlane nearer = plane, farther = plane;
  nearer.inverse_depth[0] += step, farther.inverse_depth[0] -= step;
  const Eigen::Vector2f centre_by_w = (MakeWarp(scene, nearer, 2, Eigen::Vector2f::Zero())->CentrePx() -
                                       MakeWarp(scene, farther, 2, Eigen::Vector2f::Zero())->CentrePx()) /
                                      static_cast<float>(2 * step);
  EXPECT_NEAR((centre_by_w - warp.CentreByInverseDepth()).norm() / centre_by_w.norm(), 0, 1e-3);

  const auto at = [&](float du, float dv) -> Eigen::Vector2f {
    const Eigen::Vector3f q = warp.centre + warp.by_u * du + warp.by_v * dv;
    return q.head<2>() / q.z();
  };
  Eigen::Matrix2f by_px;
  by_px << (at(1, 0) - at(-1, 0)) / 2, (at(0, 1) - at(0, -1)) / 2;
  EXPECT_NEAR((by_px - warp.PxByReferencePx()).norm(), 0, 1e-4f);
}

/// Bilinear samples of a smoothed picture lose a little where they fall between pixels, with waves of at least 8 pixels
/// of level 1 (16 of level 0): 1 - NCC stays below 0.001 (0.0002), and the peak within 0.15 pixels of the true place.
/// Pyramids that are shifted by a quarter of a pixel would move it by up to half a pixel, as the views are rolled.
TEST(WindowNcc, IsOneOnTheTruePlaneAlone) {
  for (const auto& [level, tolerance] : {std::pair{0, 2e-4f}, {1, 1e-3f}}) {
    const StereoScene scene = SceneAtLevel(level);
    for (const int shift : {-4, 0, 5}) {
      const WindowPlane plane = TruePlane(scene, 0, (48 >> level) + shift, (48 >> level) - shift);
      const WindowTexture texture = *ReferenceTexture(scene, plane);
      for (int view = 0; view < scene.NumViews(); ++view) {
        const auto loss = [&](const Eigen::Vector2f& offset_px) {
          const WindowWarp warp = *MakeWarp(scene, plane, view, offset_px);
          return 1 - *WindowNcc(scene.views[view].gray, scene.options.window_px, warp, texture);
        };
        const float at = loss({0, 0});
        EXPECT_LT(at, tolerance) << "level " << level << " view " << view;
        for (const Eigen::Vector2f& beside : {Eigen::Vector2f(0.5f, 0), Eigen::Vector2f(0, 0.5f)}) {
          const float before = loss(-beside), after = loss(beside);
          EXPECT_GT(before + after - 2 * at, tolerance) << "level " << level << " view " << view;
          const float peak_px = 0.25f * (before - after) / (before + after - 2 * at);  // of a parabola
          EXPECT_NEAR(peak_px, 0, 0.15) << "level " << level << " view " << view;
        }
      }
    }
  }
}

TEST(WindowNcc, IsNothingOutsideTheImage) {
  const StereoScene scene = SceneAtLevel(0);
  const WindowPlane plane = TruePlane(scene, 0, 48, 48);
  const WindowTexture texture = *ReferenceTexture(scene, plane);
  const WindowWarp outside = *MakeWarp(scene, plane, 1, {47, 0});
  EXPECT_FALSE(WindowNcc(scene.views[1].gray, scene.options.window_px, outside, texture));
  EXPECT_FALSE(LineariseWindow(scene.views[1].texels, scene.options.window_px, outside, texture, true));
  EXPECT_FALSE(SearchOffset(scene.views[1].gray, scene.options.window_px, outside, texture, 2));
  EXPECT_FALSE(ReferenceTexture(scene, TruePlane(scene, 0, 2, 48)));
}

TEST(SearchOffset, FindsAKnownShift) {
  const StereoScene scene = SceneAtLevel(0);
  const WindowPlane plane = TruePlane(scene, 0, 48, 48);
  const WindowTexture texture = *ReferenceTexture(scene, plane);
  for (const Eigen::Vector2f& shift : {Eigen::Vector2f(3, -2), Eigen::Vector2f(-5, 4), Eigen::Vector2f(0, 0)}) {
    // Whole pixels of the reference, so that the true place is among those that are tried.
    const WindowWarp true_warp = *MakeWarp(scene, plane, 2, Eigen::Vector2f::Zero());
    const Eigen::Vector2f wrong_px = -(true_warp.PxByReferencePx() * shift);
    const WindowWarp warp = *MakeWarp(scene, plane, 2, wrong_px);
    const std::optional<OffsetMatch> match =
        SearchOffset(scene.views[2].gray, scene.options.window_px, warp, texture, 6);
    ASSERT_TRUE(match);
    EXPECT_NEAR(match->offset_px.norm(), 0, 0.05) << "not back at the true place";
    EXPECT_GT(match->ncc, 0.999f);
  }
}

TEST(SearchOffset, FitsItsRadiusToTheImagesEdge) {
  const StereoScene scene = SceneAtLevel(0);
  const WindowPlane plane = TruePlane(scene, 0, 5, 48);
  const WindowTexture texture = *ReferenceTexture(scene, plane);
  // A pixel beside its true place there are three pixels left of the window, not six.
  const WindowWarp warp = *MakeWarp(scene, plane, 0, {1, 0});
  const std::optional<OffsetMatch> match = SearchOffset(scene.views[0].gray, scene.options.window_px, warp, texture, 6);
  ASSERT_TRUE(match);
  EXPECT_NEAR(match->offset_px.norm(), 0, 1e-3);
}

TEST(ReferenceTexture, DoesNotCountPixelsOffTheObject) {
  // From column 51 on the reference view shows something else; the mask ends at column 49.
  ImageSet images = PlaneScene().images;
  cv::Mat1f picture = images.views[0].gray[0].clone();
  images.views[0].mask = cv::Mat1b(kSidePx, kSidePx, std::uint8_t{255});
  for (int y = 0; y < kSidePx; ++y) {
    for (int x = 50; x < kSidePx; ++x) {
      if (x > 50) picture(y, x) = static_cast<float>(0.5 + 0.4 * std::sin(1.3 * x) * std::cos(1.7 * y));
      images.views[0].mask(y, x) = 0;
    }
  }
  images.views[0].gray = BuildPyramid(picture, kNumLevels);
  const auto ncc = [&](const ImageSet& set, float* weight_off_object) {
    const StereoScene scene = *MakeStereoScene(set, PlaneScene().truth, {.level = 0}, {});
    const WindowPlane plane = TruePlane(scene, 0, 48, 48);
    const WindowTexture texture = *ReferenceTexture(scene, plane);
    *weight_off_object = 0;
    for (int v = 0; v < 7; ++v) *weight_off_object += texture.weight.segment(7 * v + 5, 2).sum();
    return *WindowNcc(scene.views[1].gray, 7, *MakeWarp(scene, plane, 1, Eigen::Vector2f::Zero()), texture);
  };
  float weight = 0;
  EXPECT_GT(ncc(images, &weight), 0.98f);
  EXPECT_EQ(weight, 0);
  images.views[0].mask.release();
  EXPECT_LT(ncc(images, &weight), 0.9f) << "the other thing makes no difference: nothing was tested";
  EXPECT_GT(weight, 0);
}

}  // namespace
}  // namespace rigcal::stereo
