#include "tests/match/synthetic_plane.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace rigcal::test {
namespace {

constexpr int kNumWaves = 60;
constexpr double kFocalLengthPx = 1000;

Camera PinholeCamera(cv::Size size) {
  Camera camera;
  camera.id = camera.physical_id = "camera";
  camera.width_px = size.width, camera.height_px = size.height;
  camera.fx_px = camera.fy_px = kFocalLengthPx;
  camera.cx_px = size.width / 2.0 - 0.5, camera.cy_px = size.height / 2.0 - 0.5;
  return camera;
}

Eigen::Vector3d PointOnPlane(const RigCalibration& truth, int view, const Eigen::Vector2d& x_px) {
  const Rigid3d world_from_cam = truth.views[view].cam_from_world.Inverse();
  const Eigen::Vector3d direction = world_from_cam.rotation * *RayInCam(truth.CameraOf(view), x_px);
  return world_from_cam.translation - direction * (world_from_cam.translation.z() / direction.z());
}

}  // namespace

WaveTexture::WaveTexture(double shortest, double longest, double contrast, std::uint64_t seed)
    : amplitude_(contrast * std::sqrt(2.0 / kNumWaves)) {
  Random random(seed);
  constexpr double kTurn = 2 * std::numbers::pi;
  for (int i = 0; i < kNumWaves; ++i) {
    const double frequency = kTurn * random.Uniform(1 / longest, 1 / shortest), angle = random.Uniform(0, kTurn);
    waves_.push_back({{frequency * std::cos(angle), frequency * std::sin(angle)}, random.Uniform(0, kTurn)});
  }
}

double WaveTexture::At(const Eigen::Vector2d& x) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.frequency.dot(x) + wave.phase);
  return 0.5 + amplitude_ * sum;
}

View LookAtOrigin(const std::string& name, double distance, double azimuth_rad, double elevation_rad, double roll_rad) {
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond turned = Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(elevation_rad, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(azimuth_rad, Eigen::Vector3d::UnitY()) * facing;
  return {name, 0, {turned, {0, 0, distance}}};
}

Eigen::Vector2d TruePixel(const RigCalibration& truth, int view, const Eigen::Vector3d& x_in_world) {
  return *Project(truth.CameraOf(view), truth.views[view].cam_from_world * x_in_world);
}

Eigen::Vector2d TransferOverPlane(const RigCalibration& truth, int from, const Eigen::Vector2d& x_px, int to) {
  return TruePixel(truth, to, PointOnPlane(truth, from, x_px));
}

PlaneScene RenderPlane(const WaveTexture& texture, const std::vector<View>& views, cv::Size size, int num_levels,
                       double noise_sigma, std::uint64_t noise_seed) {
  PlaneScene scene;
  scene.truth.cameras = {PinholeCamera(size)};
  scene.truth.views = views;
  Random random(noise_seed);
  for (int v = 0; v < scene.truth.NumViews(); ++v) {
    cv::Mat1f image(size);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const Eigen::Vector3d p = PointOnPlane(scene.truth, v, {x, y});
        const double noise = noise_sigma > 0 ? noise_sigma * random.Normal() : 0.0;
        image(y, x) = static_cast<float>(texture.At(p.head<2>()) + noise);
      }
    }
    ViewImages view_images;
    view_images.name = views[v].name;
    view_images.gray = BuildPyramid(image, num_levels);
    view_images.undistorted_with = scene.truth.cameras[0];
    scene.images.views.push_back(view_images);
  }
  return scene;
}

std::vector<Patch> PatchesOnPlane(int num_views, double spacing, int per_side) {
  std::vector<int> all(static_cast<std::size_t>(num_views));
  for (int v = 0; v < num_views; ++v) all[v] = v;
  std::vector<Patch> patches;
  for (int j = 0; j < per_side; ++j) {
    for (int i = 0; i < per_side; ++i) {
      const double middle = (per_side - 1) / 2.0;
      patches.push_back({{(i - middle) * spacing, (j - middle) * spacing, 0}, {0, 0, 1}, 0, all, 1.0f});
    }
  }
  return patches;
}

}  // namespace rigcal::test

namespace rigcal {
namespace {

TEST(SyntheticPlane, CamerasSeeTheTexturedSide) {
  RigCalibration truth;
  truth.views = {test::LookAtOrigin("a", 1000, 0.3, -0.2, 0.1)};
  const Eigen::Vector3d centre = CentreInWorld(truth.views[0].cam_from_world);
  EXPECT_NEAR(centre.norm(), 1000, 1e-9);
  EXPECT_GT(centre.z(), 900);
}

}  // namespace
}  // namespace rigcal
