#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/validate/compare.h"

namespace rigcal {
namespace {

constexpr std::size_t kMinViews = 2;  ///< the volume is what at least two views share

bool IsInPicture(const RigCalibration& calibration, int view, const Eigen::Vector3d& x_in_world) {
  const Camera& camera = calibration.CameraOf(view);
  const auto x_px = Project(camera, calibration.views[view].cam_from_world * x_in_world);
  return x_px && x_px->x() >= 0 && x_px->y() >= 0 && x_px->x() <= camera.width_px - 1 &&
         x_px->y() <= camera.height_px - 1;
}

std::vector<int> ViewsThatSee(const RigCalibration& calibration, const Eigen::Vector3d& x_in_world) {
  std::vector<int> views;
  for (int j = 0; j < calibration.NumViews(); ++j) {
    if (IsInPicture(calibration, j, x_in_world)) views.push_back(j);
  }
  return views;
}

/// The point nearest to all optical axes; for parallel axes a point at the depth where neighbours overlap by half.
Eigen::Vector3d WhereCamerasLook(const RigCalibration& calibration) {
  constexpr double kMinConditionInverse = 1e-4;  // all axes within about 0.6 degrees of each other: parallel
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero(), mean_centre = b, mean_axis = b;
  const auto n = static_cast<double>(calibration.NumViews());
  for (const View& view : calibration.views) {
    const Eigen::Vector3d axis = view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    const Eigen::Vector3d centre = CentreInWorld(view.cam_from_world);
    a += across;
    b += across * centre;
    mean_centre += centre / n;
    mean_axis += axis / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(a);
  if (spectrum.eigenvalues()[0] > kMinConditionInverse * spectrum.eigenvalues()[2]) return a.ldlt().solve(b);
  double depth = 0;
  for (int j = 0; j < calibration.NumViews(); ++j) {
    const Camera& camera = calibration.CameraOf(j);
    const double baseline = (CentreInWorld(calibration.views[j].cam_from_world) - mean_centre).norm();
    depth = std::max(depth, 4 * baseline * camera.fx_px / camera.width_px);  // half of 2 x baseline x f / (w / 2)
  }
  return mean_centre + depth * mean_axis.normalized();
}

/// Half the side of a cube about the point the cameras look at, the size of what the median view takes in there.
double HalfSide(const RigCalibration& calibration, const Eigen::Vector3d& x_in_world) {
  constexpr double kMaxShareOfDistance = 0.5;  // stay clear of the cameras themselves, however wide the lens
  std::vector<double> half_sides;
  double nearest = std::numeric_limits<double>::infinity();
  for (int j = 0; j < calibration.NumViews(); ++j) {
    const Camera& camera = calibration.CameraOf(j);
    const double distance = (CentreInWorld(calibration.views[j].cam_from_world) - x_in_world).norm();
    nearest = std::min(nearest, distance);
    half_sides.push_back(0.5 * distance * std::max(camera.width_px / camera.fx_px, camera.height_px / camera.fy_px));
  }
  std::nth_element(half_sides.begin(), half_sides.begin() + half_sides.size() / 2, half_sides.end());
  return std::min(half_sides[half_sides.size() / 2], kMaxShareOfDistance * nearest);
}

template <typename Use>
void ForLattice(const Eigen::AlignedBox3d& box, int per_side, const Use& use) {
  const Eigen::Vector3d step = box.sizes() / per_side;
  for (int x = 0; x < per_side; ++x) {
    for (int y = 0; y < per_side; ++y) {
      for (int z = 0; z < per_side; ++z) {
        use(Eigen::Vector3d(box.min() + step.cwiseProduct(Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5))));
      }
    }
  }
}

}  // namespace

Result<std::vector<ComparePoint>> SpreadPoints(const RigCalibration& reference) {
  constexpr int kCoarsePerSide = 20, kPerSide = 12;  // 12^3, of which 10^3 lie in the pictures of an ordinary ring
  std::vector<ComparePoint> points;
  if (reference.views.size() >= kMinViews) {
    const Eigen::Vector3d centre = WhereCamerasLook(reference);
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(HalfSide(reference, centre));
    Eigen::AlignedBox3d shared;
    const double coarse_half_step = half.x() / kCoarsePerSide;
    ForLattice({centre - half, centre + half}, kCoarsePerSide, [&](const Eigen::Vector3d& x_in_world) {
      if (ViewsThatSee(reference, x_in_world).size() >= kMinViews) shared.extend(x_in_world);
    });
    if (!shared.isEmpty()) {
      const Eigen::Vector3d margin = Eigen::Vector3d::Constant(coarse_half_step);
      ForLattice({shared.min() - margin, shared.max() + margin}, kPerSide, [&](const Eigen::Vector3d& x_in_world) {
        std::vector<int> views = ViewsThatSee(reference, x_in_world);
        if (views.size() >= kMinViews) points.push_back({x_in_world, std::move(views)});
      });
    }
  }
  if (points.empty()) {
    return Fail(ErrorCode::kBadInput, "comparison: none of the {} reference views share any volume, needs at least {}",
                reference.NumViews(), kMinViews);
  }
  return points;
}

}  // namespace rigcal
