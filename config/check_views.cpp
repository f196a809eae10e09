#include "config/check_views.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace rigcal {
namespace {

/// Least eigenvalue of the mean of I - d d^T (d: optical axes) at which the point where the axes meet is believed:
/// about 10 degrees of scatter between the axes. It may lie anywhere when they are nearly parallel.
constexpr double kMinAxisScatter = 0.03;
/// Farthest common volume that counts, as a multiple of the cameras' spread: beyond, the angle between the rays of two
/// views is about a degree, and nothing can be triangulated.
constexpr double kMaxDepthPerSpread = 50;
constexpr int kRaysPerSide = 7;  // of the grid of rays that stands for a view's picture
constexpr std::size_t kMaxNamed = 3;

using Ray = std::array<Eigen::Vector3d, 2>;  // centre and direction in the world

Eigen::Vector3d AxisInWorld(const View& view) {
  return view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
}

/// The point nearest to all optical axes; nothing when these are nearly parallel.
std::optional<Eigen::Vector3d> MeetingPoint(const RigCalibration& calibration) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const View& view : calibration.views) {
    const Eigen::Vector3d axis = AxisInWorld(view);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    normal += across;
    right += across * CentreInWorld(view.cam_from_world);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal / calibration.NumViews());
  if (eigen.eigenvalues()[0] < kMinAxisScatter) return std::nullopt;
  return normal.ldlt().solve(right);
}

double SpreadOfCentres(const RigCalibration& calibration) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : calibration.views) mean += CentreInWorld(view.cam_from_world) / calibration.NumViews();
  double spread = 0;
  for (const View& view : calibration.views)
    spread = std::max(spread, (CentreInWorld(view.cam_from_world) - mean).norm());
  return spread;
}

std::vector<Ray> GridRays(const RigCalibration& calibration, int v) {
  const Camera camera = Undistorted(calibration.CameraOf(v));
  const Rigid3d world_from_cam = calibration.views[v].cam_from_world.Inverse();
  std::vector<Ray> rays;
  for (int row = 0; row < kRaysPerSide; ++row) {
    for (int column = 0; column < kRaysPerSide; ++column) {
      const Eigen::Vector2d x_px((column + 0.5) * camera.width_px / kRaysPerSide - 0.5,
                                 (row + 0.5) * camera.height_px / kRaysPerSide - 0.5);
      if (const auto ray = RayInCam(camera, x_px))
        rays.push_back({world_from_cam.translation, world_from_cam.rotation * ray->normalized()});
    }
  }
  return rays;
}

/// Whether a piece of one of the rays, up to max_depth, lies in view v's frustum: in front of its camera and between
/// the planes through its centre and the four edges of its picture.
bool SeesAny(const RigCalibration& calibration, int v, const std::vector<Ray>& rays, double max_depth) {
  const Camera& camera = calibration.CameraOf(v);
  const Rigid3d& cam_from_world = calibration.views[v].cam_from_world;
  const Eigen::Matrix3d k = camera.CalibrationMatrix();
  Eigen::Matrix<double, 5, 3> inside;  // rows n with n * x_in_cam > 0 for points of the frustum
  inside.row(0) = k.row(2);
  inside.row(1) = k.row(0) + 0.5 * k.row(2);
  inside.row(2) = (camera.width_px - 0.5) * k.row(2) - k.row(0);
  inside.row(3) = k.row(1) + 0.5 * k.row(2);
  inside.row(4) = (camera.height_px - 0.5) * k.row(2) - k.row(1);
  return std::any_of(rays.begin(), rays.end(), [&](const Ray& ray) {
    const Eigen::Matrix<double, 5, 1> offset = inside * (cam_from_world * ray[0]);
    const Eigen::Matrix<double, 5, 1> slope = inside * (cam_from_world.rotation * ray[1]);
    double from = 0, to = max_depth;
    for (int i = 0; i < 5; ++i) {
      if (slope[i] > 0) from = std::max(from, -offset[i] / slope[i]);
      if (slope[i] < 0) to = std::min(to, -offset[i] / slope[i]);
      if (slope[i] == 0 && offset[i] <= 0) to = 0;
    }
    return from < to;
  });
}

std::string NameViews(const RigCalibration& calibration, const std::vector<int>& views) {
  std::string names;
  for (std::size_t i = 0; i < std::min(views.size(), kMaxNamed); ++i)
    names += fmt::format("{}'{}'", i == 0 ? "" : ", ", calibration.views[views[i]].name);
  if (views.size() > kMaxNamed) names += fmt::format(" and {} more", views.size() - kMaxNamed);
  return names;
}

std::vector<int> ViewsLookingAway(const RigCalibration& calibration) {
  std::vector<int> away;
  const std::optional<Eigen::Vector3d> meeting = MeetingPoint(calibration);
  for (int v = 0; meeting && v < calibration.NumViews(); ++v)
    if ((calibration.views[v].cam_from_world * *meeting).z() <= 0) away.push_back(v);
  return away;
}

std::vector<int> ViewsAlone(const RigCalibration& calibration, double max_depth) {
  std::vector<std::vector<Ray>> rays;
  for (int v = 0; v < calibration.NumViews(); ++v) rays.push_back(GridRays(calibration, v));
  std::vector<int> alone;
  for (int v = 0; v < calibration.NumViews(); ++v) {
    bool has_partner = false;
    for (int other = 0; other < calibration.NumViews() && !has_partner; ++other)
      has_partner = other != v && (SeesAny(calibration, other, rays[v], max_depth) ||
                                   SeesAny(calibration, v, rays[other], max_depth));
    if (!has_partner) alone.push_back(v);
  }
  return alone;
}

}  // namespace

Result<void> CheckViewsMeet(const RigCalibration& calibration) {
  const double spread = SpreadOfCentres(calibration);
  if (!(spread > 0))
    return Fail(ErrorCode::kBadInput, "all {} cameras stand in the same place: nothing can be triangulated",
                calibration.NumViews());
  if (const std::vector<int> away = ViewsLookingAway(calibration); !away.empty())
    return Fail(ErrorCode::kBadInput,
                "{} of {} cameras look away from the point where the optical axes meet: {}; are these poses "
                "world-to-camera with z forward?",
                away.size(), calibration.NumViews(), NameViews(calibration, away));
  if (const std::vector<int> alone = ViewsAlone(calibration, kMaxDepthPerSpread * spread); !alone.empty())
    return Fail(ErrorCode::kBadInput,
                "{} of {} views have no volume in common with another view (up to {} times the cameras' spread): {}",
                alone.size(), calibration.NumViews(), kMaxDepthPerSpread, NameViews(calibration, alone));
  return {};
}

}  // namespace rigcal
