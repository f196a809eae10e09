#include "sim_fixtures/surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace rigcal::sim {
namespace {

using Eigen::Vector3d;

/// Left out at both ends of a line of sight: far above single precision, far below a pixel.
constexpr double kSightMargin_m = 20e-6;
constexpr std::uint64_t kPointsTask = 2;  ///< DeriveSeed: where the surface points are drawn

bool Sees(const Studio& studio, int view, const SurfacePoint& point, const Vector3d& facet_normal) {
  const Camera& camera = studio.truth.CameraOf(view);
  const Rigid3d& cam_from_world = studio.truth.views[view].cam_from_world;
  const auto x_px = Project(camera, cam_from_world * point.x_in_world);
  if (!x_px || x_px->x() < 0 || x_px->y() < 0 || x_px->x() > camera.width_px - 1 || x_px->y() > camera.height_px - 1) {
    return false;
  }
  const Vector3d centre = CentreInWorld(cam_from_world);
  const Vector3d towards = (centre - point.x_in_world).normalized();
  const double least_cosine = std::cos(kSteepestView_deg * std::numbers::pi / 180);
  if (towards.dot(point.normal_in_world) < least_cosine || towards.dot(facet_normal) < least_cosine) return false;
  return !studio.rays.Occluded(point.x_in_world, centre, kSightMargin_m);
}

/// Running sum of the triangles' areas.
std::vector<double> CumulativeArea(const TriangleMesh& mesh) {
  std::vector<double> sum(mesh.triangles.size());
  double area = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Vector3d a = mesh.vertices_in_world[t[0]].cast<double>();
    const Vector3d b = mesh.vertices_in_world[t[1]].cast<double>();
    const Vector3d c = mesh.vertices_in_world[t[2]].cast<double>();
    sum[i] = area += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

/// Focal length / depth, median over the views.
double PixelsPerMetre(const RigCalibration& truth, const Vector3d& x_in_world) {
  constexpr double kLeastDepth_m = 1e-3;
  std::vector<double> scales;
  for (int view = 0; view < truth.NumViews(); ++view) {
    const double depth_m = (truth.views[view].cam_from_world * x_in_world).z();
    scales.push_back(truth.CameraOf(view).fx_px / std::max(depth_m, kLeastDepth_m));
  }
  const auto middle = scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2);
  std::nth_element(scales.begin(), middle, scales.end());
  return *middle;
}

}  // namespace

std::optional<SurfacePoint> SurfaceAt(const Studio& studio, int view, const Eigen::Vector2d& x_px) {
  const auto ray_in_cam = RayInCam(studio.truth.CameraOf(view), x_px);
  if (!ray_in_cam) return std::nullopt;
  const Rigid3d world_from_cam = studio.truth.views[view].cam_from_world.Inverse();
  return studio.rays.FirstHit(world_from_cam.translation, world_from_cam.rotation * *ray_in_cam);
}

std::vector<VisiblePoint> SurfacePoints(const Studio& studio, int count, int min_views) {
  const TriangleMesh& mesh = studio.rays.Meshes()[kObjectMesh];
  const std::vector<double> area = CumulativeArea(mesh);
  Random random(DeriveSeed(studio.options.random_seed, kPointsTask));
  std::vector<VisiblePoint> points;
  constexpr int kTriesPerPoint = 8;
  for (int i = 0; i < count * kTriesPerPoint && static_cast<int>(points.size()) < count; ++i) {
    const auto triangle = std::lower_bound(area.begin(), area.end(), random.Uniform() * area.back()) - area.begin();
    const auto& t = mesh.triangles[triangle];
    const double root = std::sqrt(random.Uniform()), v = root * random.Uniform(), u = root - v;
    const auto mix = [&](const std::vector<Eigen::Vector3f>& at) -> Vector3d {
      return (1 - u - v) * at[t[0]].cast<double>() + u * at[t[1]].cast<double>() + v * at[t[2]].cast<double>();
    };
    const SurfacePoint point{mix(mesh.vertices_in_world), mix(mesh.normals_in_world).normalized(), kObjectMesh};
    const Vector3d facet = (mesh.vertices_in_world[t[1]] - mesh.vertices_in_world[t[0]])
                               .cross(mesh.vertices_in_world[t[2]] - mesh.vertices_in_world[t[0]])
                               .cast<double>()
                               .normalized();
    VisiblePoint visible{point.x_in_world, point.normal_in_world, {}};
    for (int view = 0; view < studio.truth.NumViews(); ++view) {
      if (Sees(studio, view, point, facet)) visible.views.push_back(view);
    }
    if (static_cast<int>(visible.views.size()) >= min_views) points.push_back(std::move(visible));
  }
  return points;
}

std::vector<double> DistancesToSurface_px(const Studio& studio, const std::vector<Vector3d>& points_in_world,
                                          const Execution& execution) {
  constexpr int kPerTask = 256;
  std::vector<double> distances_px(points_in_world.size());
  const auto measure = [&](int i) {
    const auto nearest = studio.rays.Nearest(points_in_world[i], kFarthest_m);
    const double distance_m = nearest ? (*nearest - points_in_world[i]).norm() : kFarthest_m;
    distances_px[i] = distance_m * PixelsPerMetre(studio.truth, points_in_world[i]);
  };
  const bool done = ParallelFor(execution, static_cast<int>(points_in_world.size()), measure, kPerTask);
  return done ? distances_px : std::vector<double>();
}

}  // namespace rigcal::sim
