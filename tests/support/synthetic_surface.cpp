#include "tests/support/synthetic_surface.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/random.h"

namespace rigcal::test {
namespace {

constexpr int kNumWaves = 40;
constexpr double kTurn = 2 * std::numbers::pi;
/// Rolls step by the golden section of a turn: never two alike.
constexpr double kRollStepRad = kTurn * 0.618;

Camera PinholeCamera(cv::Size size) {
  Camera camera;
  camera.id = camera.physical_id = "camera";
  camera.width_px = size.width, camera.height_px = size.height;
  camera.fx_px = camera.fy_px = kSceneFocalLengthPx;
  camera.cx_px = size.width / 2.0 - 0.5, camera.cy_px = size.height / 2.0 - 0.5;
  return camera;
}

}  // namespace

SolidTexture::SolidTexture(double shortest, double longest, double contrast, std::uint64_t seed)
    : amplitude_(contrast * std::sqrt(2.0 / kNumWaves)) {
  Random random(seed);
  for (int i = 0; i < kNumWaves; ++i) {
    const Eigen::Vector3d direction = Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal()).normalized();
    const double frequency = kTurn * random.Uniform(1 / longest, 1 / shortest);
    waves_.push_back({frequency * direction, random.Uniform(0, kTurn)});
  }
}

double SolidTexture::At(const Eigen::Vector3d& x_in_world) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.frequency.dot(x_in_world) + wave.phase);
  return 0.5 + amplitude_ * sum;
}

FirstHit PlaneAtHeight(double z_in_world) {
  return [z_in_world](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) -> std::optional<double> {
    const double t = (z_in_world - origin.z()) / direction.z();
    if (!(t > 0)) return std::nullopt;
    return t;
  };
}

FirstHit SphereAtOrigin(double radius) {
  return [radius](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) -> std::optional<double> {
    // |origin + t direction|^2 = radius^2
    const double a = direction.squaredNorm(), b = origin.dot(direction), c = origin.squaredNorm() - radius * radius;
    const double discriminant = b * b - a * c;
    const double t = (-b - std::sqrt(std::max(0.0, discriminant))) / a;
    if (discriminant < 0 || !(t > 0)) return std::nullopt;
    return t;
  };
}

FirstHit NearerOf(FirstHit a, FirstHit b) {
  return [a = std::move(a), b = std::move(b)](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const std::optional<double> by_a = a(origin, direction), by_b = b(origin, direction);
    return by_a && (!by_b || *by_a < *by_b) ? by_a : by_b;
  };
}

View ViewOfOrigin(const std::string& name, const Eigen::Vector3d& from_in_world, double roll_rad) {
  const Eigen::Vector3d forward = -from_in_world.normalized();
  const Eigen::Vector3d right = forward.unitOrthogonal();
  Eigen::Matrix3d cam_from_world;
  cam_from_world << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  return {name,
          0,
          {Eigen::Quaterniond(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()) * cam_from_world),
           {0, 0, kSceneDistance}}};
}

std::vector<View> ViewsAboutZ(int count, double tilt_rad) {
  std::vector<View> views = {ViewOfOrigin("0", Eigen::Vector3d::UnitZ(), 0)};
  for (int i = 1; i < count; ++i) {
    const double turn = kTurn * i / (count - 1);
    const Eigen::Vector3d from(std::sin(tilt_rad) * std::cos(turn), std::sin(tilt_rad) * std::sin(turn),
                               std::cos(tilt_rad));
    views.push_back(ViewOfOrigin(std::to_string(i), from, i * kRollStepRad));
  }
  return views;
}

std::vector<View> ViewsAround(int count, double elevation_rad) {
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    const double turn = kTurn * i / count, elevation = i % 2 == 0 ? elevation_rad : -elevation_rad;
    const Eigen::Vector3d from(std::cos(elevation) * std::sin(turn), std::sin(elevation),
                               std::cos(elevation) * std::cos(turn));
    views.push_back(ViewOfOrigin(std::to_string(i), from, i * kRollStepRad));
  }
  return views;
}

SurfaceScene RenderSurface(const FirstHit& surface, const SolidTexture& texture, const std::vector<View>& views,
                           cv::Size size, int num_levels) {
  SurfaceScene scene;
  scene.truth.cameras = {PinholeCamera(size)};
  scene.truth.views = views;
  bool all_hit = true;
  for (const View& view : views) {
    const Rigid3d world_from_cam = view.cam_from_world.Inverse();
    cv::Mat1f image(size, 0.0f);
    cv::Mat1b mask(size, std::uint8_t{0});
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const Eigen::Vector3d direction = world_from_cam.rotation * *RayInCam(scene.truth.cameras[0], {x, y});
        const std::optional<double> t = surface(world_from_cam.translation, direction);
        all_hit = all_hit && t;
        if (!t) continue;
        image(y, x) = static_cast<float>(texture.At(world_from_cam.translation + *t * direction));
        mask(y, x) = 255;
      }
    }
    ViewImages pictures;
    pictures.name = view.name;
    pictures.gray = BuildPyramid(image, num_levels);
    pictures.mask = mask;
    pictures.undistorted_with = scene.truth.cameras[0];
    scene.images.views.push_back(pictures);
  }
  if (all_hit) {
    for (ViewImages& pictures : scene.images.views) pictures.mask.release();
  }
  return scene;
}

ImageSet WithNoise(const ImageSet& images, double sigma, std::uint64_t seed) {
  ImageSet noisy = images;
  Random random(seed);
  for (ViewImages& pictures : noisy.views) {
    cv::Mat1f image = pictures.gray[0].clone();
    for (float& value : image) value += static_cast<float>(sigma * random.Normal());
    pictures.gray = BuildPyramid(image, static_cast<int>(pictures.gray.size()));
  }
  return noisy;
}

Eigen::Vector2d TrueImage(const RigCalibration& truth, int view, const Eigen::Vector3d& x_in_world) {
  return *Project(truth.CameraOf(view), truth.views[view].cam_from_world * x_in_world);
}

RigCalibration WithShiftedViews(const RigCalibration& truth, const std::vector<Eigen::Vector2d>& shift_px) {
  RigCalibration shifted = truth;
  for (std::size_t v = 0; v < shift_px.size(); ++v) {
    Rigid3d& pose = shifted.views[v].cam_from_world;
    Eigen::Matrix<double, 6, 1> delta = Eigen::Matrix<double, 6, 1>::Zero();
    delta[0] = -shift_px[v].y() / kSceneFocalLengthPx;
    delta[1] = shift_px[v].x() / kSceneFocalLengthPx;
    pose = Disturbed(pose, delta);
  }
  return shifted;
}

}  // namespace rigcal::test
